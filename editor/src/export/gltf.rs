//! Binary glTF 2.0 of a run: each sheet is a mesh with a morph target for each moment after the
//! first, each body a mesh on an animated node.
//!
//! Targets are differences from the first moment. At each moment the weight of its target is 1 and
//! all others are 0; players interpolate linearly. Lengths are metres and +y is up, as in glTF. The
//! file is a GLB: a JSON chunk and a binary chunk.

use glam::Vec3;
use serde_json::{Value, json};

use super::track::{BodyTrack, Shapes, Track};

/// Constants of glTF: component types and buffer view targets.
const FLOAT: u32 = 5126;
const UNSIGNED: u32 = 5125;
const VERTICES: u32 = 34962;
const INDICES: u32 = 34963;

/// Colours of sheets and bodies as displayed, linear.
const SHEET: [f32; 4] = [0.71, 0.033, 0.007, 1.0];
const BODY: [f32; 4] = [0.319, 0.407, 0.554, 1.0];

/// Parts of a file.
#[derive(Default)]
struct Parts {
    binary: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    meshes: Vec<Value>,
    nodes: Vec<Value>,
    samplers: Vec<Value>,
    channels: Vec<Value>,
}

impl Parts {
    /// Append numbers to the buffer. Returns the index of their view.
    fn view(&mut self, bytes: impl Iterator<Item = [u8; 4]>, target: Option<u32>) -> usize {
        let offset = self.binary.len();
        self.binary.extend(bytes.flatten());
        let mut view = json!({ "buffer": 0, "byteOffset": offset, "byteLength": self.binary.len() - offset });
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        self.views.push(view);
        self.views.len() - 1
    }

    fn accessor(&mut self, accessor: Value) -> usize {
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    /// Append vectors; with bounds where they are positions.
    fn vectors(&mut self, values: &[Vec3], bounded: bool) -> usize {
        let view = self.view(values.iter().flat_map(|v| v.to_array()).map(f32::to_le_bytes), Some(VERTICES));
        let mut accessor = json!({ "bufferView": view, "componentType": FLOAT, "count": values.len(), "type": "VEC3" });
        if bounded {
            let low = values.iter().copied().reduce(Vec3::min).unwrap_or_default();
            let high = values.iter().copied().reduce(Vec3::max).unwrap_or_default();
            (accessor["min"], accessor["max"]) = (json!(low.to_array()), json!(high.to_array()));
        }
        self.accessor(accessor)
    }

    fn uvs(&mut self, values: &[[f32; 2]]) -> usize {
        let view = self.view(values.iter().flatten().map(|v| v.to_le_bytes()), Some(VERTICES));
        self.accessor(json!({ "bufferView": view, "componentType": FLOAT, "count": values.len(), "type": "VEC2" }))
    }

    fn triangles(&mut self, triangles: &[[u32; 3]]) -> usize {
        let view = self.view(triangles.iter().flatten().map(|k| k.to_le_bytes()), Some(INDICES));
        let count = 3 * triangles.len();
        self.accessor(json!({ "bufferView": view, "componentType": UNSIGNED, "count": count, "type": "SCALAR" }))
    }

    /// Append numbers of an animation, in elements of type `kind`.
    fn numbers(&mut self, values: &[f32], kind: &str, size: usize) -> usize {
        let view = self.view(values.iter().map(|v| v.to_le_bytes()), None);
        let count = values.len() / size;
        self.accessor(json!({ "bufferView": view, "componentType": FLOAT, "count": count, "type": kind }))
    }

    /// Append the times of the moments.
    fn times(&mut self, times: &[f64]) -> usize {
        let seconds: Vec<f32> = times.iter().map(|t| *t as f32).collect();
        let input = self.numbers(&seconds, "SCALAR", 1);
        let ends = [seconds.first().copied().unwrap_or(0.0), seconds.last().copied().unwrap_or(0.0)];
        (self.accessors[input]["min"], self.accessors[input]["max"]) = (json!([ends[0]]), json!([ends[1]]));
        input
    }

    /// Animate the property `path` of a node by `output` over `input`.
    fn animate(&mut self, node: usize, path: &str, input: usize, output: usize) {
        self.samplers.push(json!({ "input": input, "output": output, "interpolation": "LINEAR" }));
        let sampler = self.samplers.len() - 1;
        self.channels.push(json!({ "sampler": sampler, "target": { "node": node, "path": path } }));
    }

    fn sheet(&mut self, name: &str, shapes: &Shapes, input: Option<usize>) {
        let Some((first, normals)) = shapes.moments.first() else { return };
        let attributes = json!({
            "POSITION": self.vectors(first, true),
            "NORMAL": self.vectors(normals, false),
            "TEXCOORD_0": self.uvs(&shapes.uvs),
        });
        let indices = self.triangles(&shapes.triangles);
        let mut primitive = json!({ "attributes": attributes, "indices": indices, "material": 0 });
        let less = |a: &[Vec3], b: &[Vec3]| -> Vec<Vec3> { a.iter().zip(b).map(|(a, b)| *a - *b).collect() };
        let others = shapes.moments.iter().skip(1);
        let targets: Vec<Value> = others
            .map(|(places, turned)| {
                let (position, normal) = (less(places, first), less(turned, normals));
                json!({ "POSITION": self.vectors(&position, true), "NORMAL": self.vectors(&normal, false) })
            })
            .collect();
        let count = targets.len();
        let mut mesh = json!({ "name": name });
        if count > 0 {
            primitive["targets"] = json!(targets);
            mesh["weights"] = json!(vec![0.0_f32; count]);
        }
        mesh["primitives"] = json!([primitive]);
        self.meshes.push(mesh);
        self.nodes.push(json!({ "name": name, "mesh": self.meshes.len() - 1 }));
        if let Some(input) = input.filter(|_| count > 0) {
            let mut weights = vec![0.0_f32; (count + 1) * count];
            (0..count).for_each(|k| weights[(k + 1) * count + k] = 1.0);
            let output = self.numbers(&weights, "SCALAR", 1);
            self.animate(self.nodes.len() - 1, "weights", input, output);
        }
    }

    fn body(&mut self, body: &BodyTrack, input: Option<usize>) {
        let Some((position, rotation)) = body.poses.first().copied() else { return };
        let attributes = json!({
            "POSITION": self.vectors(&body.shape.positions, true),
            "NORMAL": self.vectors(&body.shape.normals, false),
        });
        let indices = self.triangles(&body.shape.triangles);
        let primitive = json!({ "attributes": attributes, "indices": indices, "material": 1 });
        self.meshes.push(json!({ "name": body.name, "primitives": [primitive] }));
        self.nodes.push(json!({
            "name": body.name,
            "mesh": self.meshes.len() - 1,
            "translation": position.as_vec3().to_array(),
            "rotation": rotation.as_quat().normalize().to_array(),
        }));
        let moves = body.poses.iter().any(|pose| *pose != (position, rotation));
        if let Some(input) = input.filter(|_| moves) {
            let node = self.nodes.len() - 1;
            let places: Vec<f32> = body.poses.iter().flat_map(|p| p.0.as_vec3().to_array()).collect();
            let turns: Vec<f32> = body.poses.iter().flat_map(|p| p.1.as_quat().normalize().to_array()).collect();
            let output = self.numbers(&places, "VEC3", 3);
            self.animate(node, "translation", input, output);
            let output = self.numbers(&turns, "VEC4", 4);
            self.animate(node, "rotation", input, output);
        }
    }
}

fn material(name: &str, colour: [f32; 4], roughness: f32) -> Value {
    json!({
        "name": name,
        "doubleSided": true,
        "pbrMetallicRoughness": { "baseColorFactor": colour, "metallicFactor": 0.0, "roughnessFactor": roughness },
    })
}

/// File of a run.
pub fn binary(track: &Track, name: &str) -> Vec<u8> {
    let mut parts = Parts::default();
    let input = (track.times.len() > 1).then(|| parts.times(&track.times));
    for sheet in &track.sheets {
        parts.sheet(&sheet.name, &sheet.shapes(), input);
    }
    for body in &track.bodies {
        parts.body(body, input);
    }
    let mut all = json!({
        "asset": { "version": "2.0", "generator": concat!("Sheetwork ", env!("CARGO_PKG_VERSION")) },
        "scene": 0,
        "scenes": [{ "name": name, "nodes": (0..parts.nodes.len()).collect::<Vec<_>>() }],
    });
    // glTF forbids empty lists.
    let lists = [
        ("nodes", parts.nodes),
        ("meshes", parts.meshes),
        ("accessors", parts.accessors),
        ("bufferViews", parts.views),
    ];
    for (key, list) in lists {
        if !list.is_empty() {
            all[key] = json!(list);
        }
    }
    if all.get("meshes").is_some() {
        all["materials"] = json!([material("sheet", SHEET, 0.4), material("body", BODY, 0.6)]);
    } else {
        all["scenes"] = json!([{ "name": name }]);
    }
    if !parts.channels.is_empty() {
        all["animations"] = json!([{ "name": "run", "samplers": parts.samplers, "channels": parts.channels }]);
    }
    if !parts.binary.is_empty() {
        all["buffers"] = json!([{ "byteLength": parts.binary.len() }]);
    }
    container(all.to_string().into_bytes(), parts.binary)
}

/// Join the two chunks into one file, padded to whole words: JSON with blanks; binary numbers are
/// whole words.
fn container(mut text: Vec<u8>, binary: Vec<u8>) -> Vec<u8> {
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut chunks = vec![(*b"JSON", text)];
    if !binary.is_empty() {
        chunks.push((*b"BIN\0", binary));
    }
    let length = 12 + chunks.iter().map(|c| 8 + c.1.len()).sum::<usize>();
    let mut file = Vec::with_capacity(length);
    file.extend(b"glTF");
    file.extend(2_u32.to_le_bytes());
    file.extend((length as u32).to_le_bytes());
    for (kind, content) in chunks {
        file.extend((content.len() as u32).to_le_bytes());
        file.extend(kind);
        file.extend(content);
    }
    file
}
