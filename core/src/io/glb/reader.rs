//! Reading binary glTF: the triangles of the default scene, placed by its nodes.
//!
//! Read are triangles, strips and fans, indexed or not, positions in any component type the specification and
//! `KHR_mesh_quantization` allow. A node that mirrors turns its faces round. Primitives of one node that share
//! their positions share their vertices; nothing else is merged. Points and lines are passed over; skins and
//! morph targets leave the shape as it was modelled. Refused in a sentence: sparse accessors, compression,
//! data in other files, required extensions that are not known.
//!
//! A scene may place one mesh many times. To keep memory in proportion to the file, what is read may be
//! [`MOST_EXPANSION`] times as large as the file.

use glam::{DAffine3, DVec3};
use rustc_hash::FxHashMap;

use super::accessor::{accessor, accessor_place, indices, positions};
use super::scene::{Primitive, Scenes};
use crate::io::watch::Watch;
use crate::io::{Defect, LARGEST_COUNT, Parsed, Place, with_room};
use crate::mesh::TriangleMesh;

/// How many times as large as the file its mesh may be, counting 24 bytes a vertex and 12 a face.
const MOST_EXPANSION: u64 = 64;

/// Parses a whole file.
pub(in crate::io) fn parse(bytes: &[u8], watch: &Watch) -> Parsed<TriangleMesh> {
    let (json, binary) = chunks(bytes)?;
    let scenes = Scenes::parse(json)?;
    let room = MOST_EXPANSION.saturating_mul(bytes.len() as u64);
    let mut reader = Reader { scenes: &scenes, binary, mesh: TriangleMesh::default(), room, watch };
    reader.read_scene()?;
    match reader.mesh.faces.is_empty() {
        true => Err((Place::Whole, Defect::NoFaces)),
        false => Ok(reader.mesh),
    }
}

/// The JSON and the binary chunk; the latter may be missing, then it is empty.
fn chunks(bytes: &[u8]) -> Parsed<(&[u8], &[u8])> {
    let not_glb = |reason: &str| {
        (Place::Whole, Defect::NotThisFormat { format: "a binary glTF file", reason: reason.to_owned() })
    };
    let header = |problem: &str| (Place::Whole, Defect::Header { problem: problem.to_owned() });
    let cut = (Place::Whole, Defect::CutShort { part: "the end that its header states" });
    let word = |at: usize| bytes.get(at..)?.first_chunk().map(|&word| u32::from_le_bytes(word));
    if !bytes.starts_with(b"glTF") {
        return Err(not_glb("it does not begin with 'glTF'"));
    }
    let (Some(version), Some(length)) = (word(4), word(8)) else { return Err(cut) };
    if version != 2 {
        return Err(header(&format!("its version is {version}, and only 2 can be read")));
    }
    let mut rest = bytes.get(12..length as usize).ok_or(cut.clone())?;
    let (mut json, mut binary) = (None, None);
    while let Some(&[a, b, c, d, kind @ ..]) = rest.first_chunk::<8>() {
        let length = u32::from_le_bytes([a, b, c, d]) as usize;
        let chunk = rest.get(8..8 + length).ok_or(cut.clone())?;
        match &kind {
            b"JSON" if json.is_none() => json = Some(chunk),
            b"BIN\0" if binary.is_none() => binary = Some(chunk),
            _ => {}
        }
        rest = &rest[8 + length..];
    }
    let json = json.ok_or_else(|| header("the JSON chunk is missing"))?;
    Ok((json, binary.unwrap_or_default()))
}

struct Reader<'a, 'w> {
    scenes: &'a Scenes,
    binary: &'a [u8],
    mesh: TriangleMesh,
    /// Bytes that may yet be added to the mesh.
    room: u64,
    watch: &'a Watch<'w>,
}

impl Reader<'_, '_> {
    /// The default scene, else the first; without scenes all nodes that have no parent, without nodes all meshes.
    fn read_scene(&mut self) -> Parsed<()> {
        let scenes = self.scenes;
        let place = |name: &str, index: usize| Place::Element { name: name.to_owned(), index: index as u64 };
        let wrong = |place, problem: &str| (place, Defect::Scene { problem: problem.to_owned() });
        let mut has_parent = vec![false; scenes.nodes.len()];
        for (parent, child) in scenes
            .nodes
            .iter()
            .enumerate()
            .flat_map(|(n, node)| node.children.iter().map(move |&child| (n, child)))
        {
            let seen = has_parent.get_mut(child);
            let seen =
                seen.ok_or_else(|| wrong(place("node", parent), "it has a child that does not exist"))?;
            if std::mem::replace(seen, true) {
                return Err(wrong(place("node", child), "it is the child of more than one node"));
            }
        }
        if scenes.nodes.is_empty() {
            return (0..scenes.meshes.len()).try_for_each(|mesh| self.read_mesh(mesh, None));
        }
        let number = scenes.scene.unwrap_or(0);
        let roots: Vec<usize> = match scenes.scenes.get(number) {
            Some(scene) => scene.nodes.clone(),
            None if scenes.scene.is_none() => (0..scenes.nodes.len()).filter(|&n| !has_parent[n]).collect(),
            None => return Err(wrong(place("scene", number), "the default scene does not exist")),
        };
        let mut visited = vec![false; scenes.nodes.len()];
        for root in roots {
            let mut open: Vec<(usize, Option<DAffine3>)> = vec![(root, None)];
            while let Some((number, parent)) = open.pop() {
                let missing = || wrong(place("scene", 0), "it has a node that does not exist");
                let node = scenes.nodes.get(number).ok_or_else(missing)?;
                if std::mem::replace(&mut visited[number], true) {
                    return Err(wrong(place("node", number), "the scene reaches it twice"));
                }
                let placement = match (parent, node.placement()) {
                    (Some(parent), Some(own)) => Some(parent * own),
                    (parent, own) => parent.or(own),
                };
                if let Some(mesh) = node.mesh {
                    // The place of a skinned mesh is that of its joints; modelled it was where its own numbers say.
                    self.read_mesh(mesh as usize, placement.filter(|_| node.skin.is_none()))?;
                }
                open.extend(node.children.iter().rev().map(|&child| (child, placement)));
            }
        }
        Ok(())
    }

    fn read_mesh(&mut self, number: usize, placement: Option<DAffine3>) -> Parsed<()> {
        let place = || Place::Element { name: "mesh".to_owned(), index: number as u64 };
        let missing = || (place(), Defect::Scene { problem: "the mesh does not exist".to_owned() });
        let mesh = self.scenes.meshes.get(number).ok_or_else(missing)?;
        // The first vertex of each accessor of positions that was read for this node.
        let mut read = FxHashMap::default();
        for primitive in &mesh.primitives {
            self.watch.pass()?;
            match (primitive.mode, primitive.attributes.position) {
                (4..=6, Some(position)) => self.read_primitive(primitive, position, placement, &mut read)?,
                (0..=6, _) => {}
                (mode, _) => {
                    let problem = format!("a primitive has the mode {mode}, which glTF does not have");
                    return Err((place(), Defect::Scene { problem }));
                }
            }
        }
        Ok(())
    }

    fn read_primitive(
        &mut self,
        primitive: &Primitive,
        position: usize,
        placement: Option<DAffine3>,
        read: &mut FxHashMap<usize, u32>,
    ) -> Parsed<()> {
        let source = accessor(self.scenes, position)?;
        primitive.check_compression(source).map_err(|defect| (accessor_place(position), defect))?;
        let count = source.count;
        let first = match read.get(&position) {
            Some(&first) => first,
            None => {
                let first = self.mesh.positions.len() as u64;
                self.spend(count, 24)?;
                if first + count > LARGEST_COUNT {
                    return Err((Place::Whole, Defect::TooMany { what: "vertices" }));
                }
                let placed = |p: [f64; 3]| match placement {
                    Some(placement) => placement.transform_point3(DVec3::from(p)).to_array(),
                    None => p,
                };
                positions(
                    (self.scenes, self.binary),
                    position,
                    placed,
                    self.watch,
                    &mut self.mesh.positions,
                )?;
                read.insert(position, first as u32);
                first as u32
            }
        };
        let corners: Vec<u32> = match primitive.indices {
            Some(index) => indices((self.scenes, self.binary), index, count, self.watch)?,
            None => {
                let mut corners = with_room(count as usize)?;
                corners.extend(0..count as u32);
                corners
            }
        };
        let mirrored = placement.is_some_and(|placement| placement.matrix3.determinant() < 0.0);
        self.add_faces(primitive.mode, &corners, first, mirrored)
    }

    fn add_faces(&mut self, mode: u32, corners: &[u32], first: u32, mirrored: bool) -> Parsed<()> {
        let most = if mode == 4 { corners.len() / 3 } else { corners.len().saturating_sub(2) };
        self.spend(most as u64, 12)?;
        let faces = &mut self.mesh.faces;
        if faces.len() as u64 + most as u64 > LARGEST_COUNT {
            return Err((Place::Whole, Defect::TooMany { what: "faces" }));
        }
        faces.try_reserve(most).map_err(|_| (Place::Whole, Defect::OutOfMemory))?;
        let watch = self.watch;
        let mut add = |[a, b, c]: [u32; 3]| {
            let face = if mirrored { [a, c, b] } else { [a, b, c] };
            faces.push(face.map(|corner| corner + first));
            watch.pass()
        };
        match mode {
            4 => {
                let (triangles, rest) = corners.as_chunks();
                if !rest.is_empty() {
                    let problem = format!("a primitive has {} corners, no multiple of three", corners.len());
                    return Err((Place::Whole, Defect::Scene { problem }));
                }
                triangles.iter().try_for_each(|&face| add(face))
            }
            5 => {
                (0..most).try_for_each(|i| add([corners[i], corners[i + 1 + i % 2], corners[i + 2 - i % 2]]))
            }
            _ => (0..most).try_for_each(|i| add([corners[i + 1], corners[i + 2], corners[0]])),
        }
    }

    fn spend(&mut self, elements: u64, bytes: u64) -> Parsed<()> {
        let left = elements.checked_mul(bytes).and_then(|bytes| self.room.checked_sub(bytes));
        let problem =
            || format!("it places its meshes so often that they are {MOST_EXPANSION} times the file's size");
        self.room = left.ok_or_else(|| (Place::Whole, Defect::Scene { problem: problem() }))?;
        Ok(())
    }
}
