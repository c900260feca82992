//! Which elements belong together.

/// Union–find with path halving; the lowest element stands for its set.
pub(in crate::conversion) struct DisjointSets {
    parent: Vec<u32>,
}

impl DisjointSets {
    pub(in crate::conversion) fn new(len: usize) -> Self {
        Self { parent: (0..len as u32).collect() }
    }

    pub(in crate::conversion) fn find(&mut self, mut at: usize) -> usize {
        while self.parent[at] as usize != at {
            self.parent[at] = self.parent[self.parent[at] as usize];
            at = self.parent[at] as usize;
        }
        at
    }

    pub(in crate::conversion) fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.find(a), self.find(b));
        self.parent[a.max(b)] = a.min(b) as u32;
    }
}
