//! From the base mesh to the finest: subdivide, project, relax, level by level.

use crate::base_mesh::head_base;
use crate::carving::carve;
use crate::faun::{head, on_limb, spacing};
use crate::relax::{Target, project_all, relax, worst_cosine};
use crate::skin::{Skin, evenness};
use crate::vector::Vec3;

/// What a mesh of the head came to.
#[derive(Debug, Clone, Copy)]
pub struct LevelReport {
    /// The level, 0 for the base mesh.
    pub level: u32,
    /// Its vertices.
    pub vertices: usize,
    /// Its faces.
    pub faces: usize,
    /// Faces turned against the field, see [`crate::relax::TURNED_COSINE`].
    pub turned: usize,
    /// The smallest cosine between a face's normal and the field's.
    pub worst_cosine: f64,
    /// The least even face: 1 equilateral, 0 degenerate.
    pub least_even: f64,
}

/// Relaxation rounds a level: coarse levels are cheap and carry the parameterisation, fine ones only even it out.
const ROUNDS: [u32; 7] = [0, 12, 150, 80, 40, 16, 10];

/// Up to this level the base vertices stay where the hand put them, so that every limb keeps its share of the mesh.
const PLACED_LEVELS: u32 = 1;
/// Up to this level horns, ears and beard are projected only: with few vertices round them, relaxation pulls them off.
const LIMB_LEVELS: u32 = 2;

/// How far eyes, mouth and nostrils have opened on a level: coarse meshes would fold over them.
fn openness(level: u32) -> f64 {
    match level {
        0 | 1 => 0.0,
        2 => 0.3,
        3 => 0.7,
        _ => 1.0,
    }
}

/// The head at `levels` subdivisions, carved at the last; `report` is called after each level and after the carving.
pub fn sculpt_head(levels: u32, mut report: impl FnMut(LevelReport)) -> Skin {
    let base = head_base();
    let mut skin = base.skin;
    let placed = skin.positions.len() as u32;
    for level in 0..=levels {
        if level > 0 {
            skin = skin.subdivided();
        }
        let open = openness(level);
        let field = move |p: Vec3| head(p, open);
        let target = Target { field: &field, spacing: &spacing };
        project_all(&mut skin, &target, 0.05);
        let pinned = held(&skin, &base.pinned, placed, level);
        relax(&mut skin, &target, &pinned, ROUNDS[(level as usize).min(ROUNDS.len() - 1)]);
        report(measure(&skin, level));
    }
    let finished = |p: Vec3| head(p, 1.0);
    carve(&mut skin, &Target { field: &finished, spacing: &spacing });
    report(measure(&skin, levels));
    skin
}

/// Measures a mesh of `level` against the head as it is on that level.
fn measure(skin: &Skin, level: u32) -> LevelReport {
    let open = openness(level);
    let field = move |p: Vec3| head(p, open);
    let (turned, worst_cosine) = worst_cosine(skin, &Target { field: &field, spacing: &spacing });
    LevelReport {
        level,
        vertices: skin.positions.len(),
        faces: skin.faces.len(),
        turned,
        worst_cosine,
        least_even: skin.faces.iter().map(|&face| evenness(skin.corners(face))).fold(1.0, f64::min),
    }
}

/// The vertices that stay on a level: tips always, limbs and hand-placed vertices on coarse levels.
fn held(skin: &Skin, tips: &[u32], placed: u32, level: u32) -> Vec<u32> {
    let holds = |v: u32| {
        tips.contains(&v)
            || (level <= PLACED_LEVELS && v < placed)
            || (level <= LIMB_LEVELS && on_limb(skin.positions[v as usize]))
    };
    (0..skin.positions.len() as u32).filter(|&v| holds(v)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_face_turns_over_and_none_degenerates_on_coarse_levels() {
        let mut reports = Vec::new();
        sculpt_head(2, |report| reports.push(report));
        assert_eq!(reports.len(), 4);
        // The last is the carved mesh, on which the carving (made for the finest level) is far too fine.
        for report in &reports[..3] {
            assert!(report.worst_cosine > 0.0 && report.least_even > 0.0, "{report:?}");
        }
    }
}
