//! A set of vertices that is cleared at the cost of what it holds.

use crate::hierarchy::Site;

/// One bit per possible member, and the list of members with their sites.
#[derive(Debug, Clone, Default)]
pub(crate) struct Marks {
    bits: Vec<u64>,
    members: Vec<(u32, Site)>,
}

impl Marks {
    /// Empties the set and makes room for members below `len`.
    pub(crate) fn reset(&mut self, len: u32) {
        for &(member, _) in &self.members {
            self.bits[member as usize / 64] = 0;
        }
        self.members.clear();
        let words = (len as usize).div_ceil(64);
        if self.bits.len() < words {
            self.bits.resize(words, 0);
        }
    }

    /// Adds a member; whether it was new.
    pub(crate) fn insert(&mut self, member: u32, site: Site) -> bool {
        let (word, bit) = (&mut self.bits[member as usize / 64], 1 << (member % 64));
        let new = *word & bit == 0;
        *word |= bit;
        if new {
            self.members.push((member, site));
        }
        new
    }

    /// The members in order of arrival.
    pub(crate) fn members(&self) -> &[(u32, Site)] {
        &self.members
    }
}
