use super::*;
use crate::conversion::creases::Creases;
use crate::mesh::{Connectivity, TriangleMesh, shapes};
use glam::DVec3;

/// A mesh as it is, nothing collapsed, its first `sharp` edges marked.
pub(in crate::conversion) fn unchanged(mesh: &TriangleMesh, sharp: usize) -> (WorkingMesh, Parameterisation) {
    let mesh = mesh.clone().with_sharp_edges(mesh.faces.iter().take(sharp).map(|f| [f[0], f[1]]).collect());
    let connectivity =
        Connectivity::build(mesh.positions.len() as u32, mesh.faces.clone()).expect("a manifold");
    let positions = mesh.positions.iter().map(|&p| DVec3::from(p)).collect();
    let working =
        WorkingMesh::new(positions, &connectivity).with_creases(Creases::marked(&mesh, &connectivity));
    (working, Parameterisation::new(mesh.faces.len() as u32))
}

/// A rhombus of equilateral triangles with side 1, `size` along each side, in the plane: unfolding it changes no length.
pub(in crate::conversion) fn rhombus(size: u32) -> TriangleMesh {
    let across = size + 1;
    let place = |v: u32| {
        let (x, y) = (f64::from(v % across), f64::from(v / across));
        [x + 0.5 * y, HEIGHT * y, 0.0]
    };
    let squares = (0..size * size).map(|k| k / size * across + k % size);
    let faces = squares.flat_map(|v| [[v, v + 1, v + across], [v + 1, v + across + 1, v + across]]);
    TriangleMesh::new((0..across * across).map(place).collect(), faces.collect())
}

/// The point of the flat faces themselves.
pub(in crate::conversion) fn place(base: &BaseMesh, mesh: &TriangleMesh, address: Address) -> DVec3 {
    let corners = base.faces()[address.face as usize].map(|v| DVec3::from(mesh.positions[v as usize]));
    (0..3).map(|k| corners[k] * address.b[k]).sum()
}

/// Some points inside and on the border of every face.
fn points(base: &BaseMesh) -> impl Iterator<Item = Address> + '_ {
    let inside = [[0.2, 0.3, 0.5], [0.6, 0.3, 0.1], [0.0, 0.4, 0.6], [0.5, 0.0, 0.5], [0.9, 0.1, 0.0]];
    (0..base.faces().len() as u32).flat_map(move |face| inside.map(|b| Address { face, b }))
}

#[test]
fn nothing_collapsed_is_its_own_map() {
    for (name, mesh) in shapes::awkward() {
        let (working, map) = unchanged(&mesh, 1);
        let domain = Domain::new(&working, &map).expect(name);
        for address in points(&domain.base) {
            let found = domain.on_input(address);
            let corners = mesh.faces[found.face as usize].map(|v| DVec3::from(mesh.positions[v as usize]));
            let there: DVec3 = (0..3).map(|k| corners[k] * found.weights[k]).sum();
            assert!(there.distance(place(&domain.base, &mesh, address)) < 1e-12, "{name}: {address:?}");
        }
    }
}

#[test]
fn the_chart_beyond_an_edge_and_back_is_the_same() {
    for (name, mesh) in shapes::awkward() {
        let (working, map) = unchanged(&mesh, 0);
        let base = Domain::new(&working, &map).expect(name).base;
        for address in points(&base) {
            for k in 0..3u8 {
                let Some(side) = base.across(address.face, k) else { continue };
                let beyond = across(&base, address, usize::from(k)).expect("a face");
                let back = across(&base, beyond, usize::from(side.k)).expect("a face");
                assert_eq!(back.face, address.face, "{name}");
                assert!((0..3).all(|k| (back.b[k] - address.b[k]).abs() < 1e-14), "{name}: {back:?}");
            }
        }
    }
}

/// The plane round a vertex: every angle is one part of one face, and every point comes back.
#[test]
fn spreading_round_a_vertex_and_back_is_the_same() {
    for (name, mesh) in shapes::awkward() {
        for sharp in [0, 4] {
            let (working, map) = unchanged(&mesh, sharp);
            let domain = Domain::new(&working, &map).expect(name);
            for v in 0..domain.base.vertex_count() {
                let fan = domain.base.fan(v);
                for (at, &(face, corner)) in fan.corners.iter().enumerate() {
                    for part in [0.1, 0.5, 0.9] {
                        let angle = angle_in_fan(&domain.base, v, at, part);
                        let (found, rest) = place_in_fan(&domain.base, v, angle);
                        assert_eq!(found, at, "{name}, {sharp} sharp, vertex {v}");
                        assert!((rest - part).abs() < 1e-12, "{name}: {rest} for {part}");
                        let address = in_sector(face, usize::from(corner), 0.4, part * FRAC_PI_3);
                        let back = domain.spread_back(v, domain.spread_round(v, address));
                        let apart =
                            place(&domain.base, &mesh, back).distance(place(&domain.base, &mesh, address));
                        assert!(apart < 1e-9, "{name}, {sharp} sharp, vertex {v}: {address:?}, {back:?}");
                    }
                }
            }
        }
    }
}

/// In a plane of equilateral triangles a blend is the weighted mean, in one face, across an edge or round a vertex.
#[test]
fn a_blend_in_a_plane_is_the_mean() {
    let mesh = rhombus(3);
    let (working, map) = unchanged(&mesh, 0);
    let domain = Domain::new(&working, &map).expect("a base mesh");
    let base = &domain.base;
    let mut blended = 0;
    for one in points(base) {
        for other in points(base) {
            let corners = [one, other].map(|address| base.faces()[address.face as usize]);
            // Faces round one vertex inside, or the same.
            let inside = |v: &u32| base.fan(*v).closed && corners[1].contains(v);
            if one.face != other.face && !corners[0].iter().any(inside) {
                continue;
            }
            for weight in [0.5, 0.2] {
                let parts = [(1.0 - weight, one), (weight, other)];
                let wanted = parts.map(|(weight, address)| place(base, &mesh, address) * weight);
                let found = domain.blend(&parts).expect("they are near");
                let apart = place(base, &mesh, found).distance(wanted[0] + wanted[1]);
                assert!(apart < 1e-9, "{one:?} {other:?}: {found:?}, {apart} apart");
                blended += 1;
            }
        }
    }
    assert!(blended > 500, "{blended}");
}

#[test]
fn points_past_the_boundary_are_put_on_it() {
    let mesh = rhombus(1);
    let (working, map) = unchanged(&mesh, 0);
    let base = Domain::new(&working, &map).expect("a base mesh").base;
    for face in 0..2 {
        for k in 0..3 {
            let mut b = [0.6; 3];
            b[k] = -0.2;
            let settled = settle(&base, Address { face, b }).expect("near");
            assert!(settled.b.iter().all(|&b| (0.0..=1.0).contains(&b)), "{settled:?}");
            assert!((settled.b.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            let inner = base.across(face, (k as u8 + 1) % 3).is_some();
            assert_eq!(settled.face != face, inner, "{face}, {k}: {settled:?}");
        }
    }
}
