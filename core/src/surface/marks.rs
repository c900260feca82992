//! A set of small integers that is cleared at the cost of what it holds.

/// One bit per possible member, and the list of members.
#[derive(Debug, Clone, Default)]
pub(super) struct Marks {
    bits: Vec<u64>,
    members: Vec<u32>,
}

impl Marks {
    /// Empties the set and makes room for members below `len`.
    pub(super) fn reset(&mut self, len: u32) {
        for &member in &self.members {
            self.bits[member as usize / 64] = 0;
        }
        self.members.clear();
        self.bits.resize((len as usize).div_ceil(64), 0);
    }

    /// Adds a member; whether it was new.
    pub(super) fn insert(&mut self, member: u32) -> bool {
        let (word, bit) = (&mut self.bits[member as usize / 64], 1 << (member % 64));
        let new = *word & bit == 0;
        *word |= bit;
        if new {
            self.members.push(member);
        }
        new
    }

    /// Whether it is a member.
    pub(super) fn contains(&self, member: u32) -> bool {
        self.bits[member as usize / 64] & 1 << (member % 64) != 0
    }

    /// The members in order of arrival.
    pub(super) fn members(&self) -> &[u32] {
        &self.members
    }
}
