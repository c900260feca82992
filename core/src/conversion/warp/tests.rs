use super::*;
use crate::hierarchy::BaseMesh;
use crate::mesh::shapes;
use std::sync::Arc;

#[test]
fn a_way_into_a_chart_and_back_is_the_same() {
    for (name, mesh) in shapes::awkward() {
        let marks: Vec<[u32; 2]> = mesh.faces.iter().take(3).map(|f| [f[0], f[1]]).collect();
        for sharp in [&[][..], &marks] {
            let base = BaseMesh::new(mesh.positions.len() as u32, mesh.faces.clone(), sharp).expect(name);
            let hierarchy = Hierarchy::new(Arc::new(base), Level(2)).expect("it fits");
            let warp = Warp::new(&hierarchy, Level(1));
            for face in 0..mesh.faces.len() {
                for &slot in warp.face_slots(face) {
                    // A way that leads into the face, in its own chart.
                    let middle = match hierarchy.layout(Level(1)).site(Slot(slot)) {
                        Site::Base(v) => {
                            let corner = hierarchy.base().faces()[face].iter().position(|&w| w == v);
                            f64::from(corner.expect("a corner") as u8) * 2.0 * FRAC_PI_3 + FRAC_PI_6
                        }
                        _ => 0.4,
                    };
                    for way in [turned(0.3, middle), turned(0.2, middle + 0.3)] {
                        let back = warp.in_chart(slot, face as u32, warp.in_frame(slot, face as u32, way));
                        assert!(
                            back.distance(way) < 1e-12,
                            "{name}, face {face}, slot {slot}: {back}, {way}"
                        );
                    }
                }
            }
        }
    }
}

/// A way along an edge is the same for both faces of it.
#[test]
fn faces_agree_on_ways_of_their_common_edge() {
    let mesh = shapes::octahedron();
    let base = BaseMesh::new(6, mesh.faces.clone(), &[]).expect("a base mesh");
    let hierarchy = Hierarchy::new(Arc::new(base), Level(2)).expect("it fits");
    let warp = Warp::new(&hierarchy, Level(1));
    let layout = hierarchy.layout(Level(1));
    for edge in 0..12u32 {
        let slot = layout.slot(layout.along_edge(edge, 1)).0;
        let low = hierarchy.base().edges()[edge as usize][0];
        for side in hierarchy.base().sides(edge).into_iter().flatten() {
            let way = warp.in_chart(slot, side.face, DVec2::new(0.5, 0.0));
            let steps = steps(way);
            let corners = hierarchy.base().faces()[side.face as usize];
            // From the low end to the high one, and none across.
            let wanted = corners.map(|v| match v {
                v if v == low => -0.5,
                v if hierarchy.base().edges()[edge as usize][1] == v => 0.5,
                _ => 0.0,
            });
            assert!((0..3).all(|k| (steps[k] - wanted[k]).abs() < 1e-12), "{edge}: {steps:?}, {wanted:?}");
        }
    }
}

#[test]
fn a_cell_holds_its_point() {
    for b in [[2.3, 0.9, 0.8], [0.0, 4.0, 0.0], [1.5, 0.0, 2.5], [0.25, 3.5, 0.25], [1.9, 1.9, 0.2]] {
        let cell = cell(b);
        assert!((cell.iter().map(|c| c.1).sum::<f64>() - 1.0).abs() < 1e-9);
        for k in 0..3 {
            let at: f64 = cell.iter().map(|(corner, weight)| f64::from(corner[k]) * weight).sum();
            assert!((at - b[k]).abs() < 1e-9, "{b:?}: {cell:?}");
        }
        assert!(cell.iter().all(|(corner, weight)| *weight >= 0.0 && corner.iter().sum::<i32>() == 4));
    }
}
