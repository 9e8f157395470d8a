//! Writer of a frame into the memory of a sample.
//!
//! A normal is the area-weighted mean of the normals of the triangles at a node. Strain is the mean
//! of (L - L₀)/L₀ over the edges at a node. Energies, normals and strain are computed for complete
//! frames only.

use glam::Vec3;
use multiversion::multiversion;

use crate::layout::{FrameHeader, LAYOUT, MAGIC, SheetHeader, UNITS, slice_mut, write_header};
use crate::plan::{FramePlan, SheetPlan};
use sheetwork::World;
use sheetwork::math::Vectors;
use sheetwork::sheet::{Sheet, Status};

/// Values of a frame in addition to the world.
#[derive(Clone, Copy, Debug)]
pub struct FrameStamp {
    pub epoch: u64,
    pub frame: u64,
    pub topology: u32,
    pub step_time: f64,
    pub written_at: u64,
    pub playing: bool,
}

/// Writes a frame of `world` to `out`, which is `plan.bytes[complete]` long and aligned.
pub fn frame(plan: &FramePlan, world: &World, moment: &FrameStamp, complete: bool, out: &mut [u8]) {
    let header = FrameHeader {
        magic: MAGIC,
        layout: LAYOUT,
        header_bytes: size_of::<FrameHeader>() as u32,
        sheet_bytes: size_of::<SheetHeader>() as u32,
        sheets: plan.sheets.len() as u32,
        bytes: out.len() as u64,
        epoch: moment.epoch,
        frame: moment.frame,
        steps: world.steps(),
        time: world.time(),
        dt: world.dt(),
        step_time: moment.step_time,
        written_at: moment.written_at,
        playing: u32::from(moment.playing),
        complete: u32::from(complete),
        bodies: plan.bodies as u32,
        topology: moment.topology,
        bodies_at: plan.bodies_at as u64,
        units: UNITS,
    };
    write_header(out, 0, header);
    let poses = world.rigid().into_iter().flat_map(|r| (0..plan.bodies).filter_map(|i| r.pose(i)));
    for (to, (place, turn)) in slice_mut::<[f32; 7]>(out, header.bodies_at, plan.bodies).iter_mut().zip(poses) {
        let (p, q) = (place.as_vec3(), turn.as_quat());
        *to = [p.x, p.y, p.z, q.x, q.y, q.z, q.w];
    }
    for (index, (plan, sheet)) in plan.sheets.iter().zip(world.sheets()).enumerate() {
        let mut header = plan.headers[usize::from(complete)];
        header.status = match sheet.state.status {
            Status::Awake => 0,
            Status::Asleep => 1,
            Status::Unstable { .. } => 2,
            Status::Frozen { .. } => 3,
        };
        header.contacts = arrays(plan, sheet, &header, out);
        if complete {
            let e = sheet.energy(world.gravity());
            header.energy = [e.kinetic, e.elastic, e.gravity, e.total];
        }
        write_header(out, size_of::<FrameHeader>() + index * size_of::<SheetHeader>(), header);
    }
}

/// Writes the arrays of a sheet and returns the number of its nodes in contact with a body.
fn arrays(plan: &SheetPlan, sheet: &Sheet, header: &SheetHeader, out: &mut [u8]) -> u32 {
    let n = sheet.node_count();
    let mut contacts = 0;
    for (flag, touches) in slice_mut::<u8>(out, header.contact, n).iter_mut().zip(sheet.touching()) {
        *flag = u8::from(*touches);
        contacts += u32::from(*touches);
    }
    if let Some((contact, pins)) = sheet.mean_forces().filter(|f| header.contact_force != 0 && f.0.len() == n) {
        positions(contact, slice_mut::<[f32; 3]>(out, header.contact_force, n));
        positions(pins, slice_mut::<[f32; 3]>(out, header.pin_force, n));
    }
    positions(&sheet.state.x, slice_mut::<[f32; 3]>(out, header.positions, n));
    if header.temperature != 0
        && let Some(temperature) = sheet.temperatures()
    {
        let all = slice_mut::<f32>(out, header.temperature, n);
        all.iter_mut().zip(temperature).for_each(|(to, from)| *to = *from as f32);
    }
    if header.normals != 0 {
        normals(plan, sheet, slice_mut::<[f32; 3]>(out, header.normals, n));
    }
    if header.strain != 0 {
        strain(plan, sheet, slice_mut::<f32>(out, header.strain, n));
    }
    contacts
}

/// Writes vectors in single precision.
#[multiversion(targets("x86_64+avx2", "x86_64+avx"))]
fn positions(from: &Vectors, to: &mut [[f32; 3]]) {
    let n = to.len();
    let [x, y, z] = from.axes().map(|axis| &axis[..n]);
    for i in 0..n {
        to[i] = [x[i] as f32, y[i] as f32, z[i] as f32];
    }
}

fn normals(plan: &SheetPlan, sheet: &Sheet, out: &mut [[f32; 3]]) {
    out.fill([0.0; 3]);
    for triangle in &plan.triangles {
        let [p, q, r] = triangle.map(|i| sheet.state.x.get(i as usize));
        let normal = (q - p).cross(r - p).as_vec3();
        for i in triangle {
            let sum = &mut out[*i as usize];
            *sum = (Vec3::from(*sum) + normal).to_array();
        }
    }
    for n in out {
        *n = Vec3::from(*n).normalize_or(Vec3::Y).to_array();
    }
}

fn strain(plan: &SheetPlan, sheet: &Sheet, out: &mut [f32]) {
    out.fill(0.0);
    for edge in &plan.edges {
        let (a, b) = (edge.a as usize, edge.b as usize);
        let length = sheet.state.x.get(a).distance(sheet.state.x.get(b));
        let strain = (length * edge.inverse_rest - 1.0) as f32;
        out[a] += strain;
        out[b] += strain;
    }
    out.iter_mut().zip(&plan.share).for_each(|(sum, share)| *sum *= share);
}
