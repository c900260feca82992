//! What an OBJ file says of sharp edges: its `l` lines, and the smoothing groups between which its faces are not smooth.

use crate::io::Defect;
use crate::io::text::whole;
use std::collections::BTreeSet;

/// The marks of a file in the making.
#[derive(Default)]
pub(super) struct Marks {
    edges: Vec<[u32; 2]>,
    /// Polygons from which on a smoothing group holds, with that; 0 for none.
    groups: Vec<(u64, i64)>,
}

impl Marks {
    /// The words of an `l` line after the keyword: a row of vertices, joined by edges.
    pub(super) fn line<'a>(
        &mut self,
        words: impl Iterator<Item = &'a [u8]>,
        mut vertex: impl FnMut(&[u8]) -> Result<u32, Defect>,
    ) -> Result<(), Defect> {
        let mut before = None;
        for word in words {
            let vertex = vertex(word)?;
            self.edges.extend(before.map(|before| [before, vertex]));
            before = Some(vertex);
        }
        Ok(())
    }

    /// The word of an `s` line after `polygons` polygons. What is no number, such as `off`, means no group.
    pub(super) fn group(&mut self, word: Option<&[u8]>, polygons: u64) {
        let group = word.and_then(|word| whole(word).ok()).unwrap_or(0);
        if self.groups.last().is_none_or(|last| last.1 != group) {
            self.groups.push((polygons, group));
        }
    }

    /// Whether there are groups that border on one another.
    pub(super) fn has_borders(&self) -> bool {
        let named: BTreeSet<i64> =
            self.groups.iter().map(|group| group.1).filter(|group| *group != 0).collect();
        named.len() > 1
    }

    /// The edges, in any order and perhaps repeated. `faces` are the triangles of polygons of the given arities, in order; the
    /// arities are needed only if there are borders.
    pub(super) fn sharp_edges(mut self, faces: &[[u32; 3]], arities: &[u32]) -> Vec<[u32; 2]> {
        if self.has_borders() {
            self.add_borders(faces, arities);
        }
        self.edges
    }

    /// Adds the edges between faces of two groups. A face of no group says nothing of its edges: programs that know of no
    /// groups write `s off` before all faces.
    fn add_borders(&mut self, faces: &[[u32; 3]], arities: &[u32]) {
        let mut sides: Vec<([u32; 2], i64)> = Vec::new();
        let (mut faces, mut groups) = (faces.iter(), self.groups.iter().peekable());
        let mut group = 0;
        for (polygon, &arity) in (0..).zip(arities) {
            while let Some(&(_, next)) = groups.next_if(|next| next.0 <= polygon) {
                group = next;
            }
            for &[a, b, c] in faces.by_ref().take(arity as usize - 2) {
                let ends = [[a, b], [b, c], [c, a]].map(|[a, b]| [a.min(b), a.max(b)]);
                sides.extend(ends.iter().filter(|_| group != 0).map(|&ends| (ends, group)));
            }
        }
        sides.sort_unstable();
        let borders = sides.windows(2).filter(|pair| pair[0].0 == pair[1].0 && pair[0].1 != pair[1].1);
        self.edges.extend(borders.map(|pair| pair[0].0));
    }
}
