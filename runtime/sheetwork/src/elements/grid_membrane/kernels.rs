//! Loops of the membrane over all packets of cells, compiled for several vector widths, with and
//! without a thermal rest state. [`crate::elements::grid_membrane`] has the equations.

use multiversion::multiversion;

use crate::elements::grid_membrane::{
    Anchor, ArmStrains, CellGeometry, Geometric, LANES, Pack, Packet, PacketRestState, Vectors, half_dot,
};

pub(crate) fn energy<const WARM: bool>(
    cell: &CellGeometry,
    packets: &[Packet],
    warmed: &[PacketRestState],
    x: &Vectors,
) -> f64 {
    let each = packets.iter().enumerate().map(|(i, p)| {
        let e = cell.strains(&cell.edges(x, p.first));
        cell.stored_energy::<WARM>(e, warmed, i, p.count)
    });
    each.sum()
}

pub(crate) fn arm_energy<const WARM: bool>(
    cell: &CellGeometry,
    packets: &[Packet],
    warmed: &[PacketRestState],
    strain: &dyn Fn(usize) -> f64,
) -> f64 {
    let each = packets.iter().enumerate().map(|(i, p)| {
        let e = std::array::from_fn(|k| Pack(std::array::from_fn(|l| strain((5 * i + k) * LANES + l))));
        half_dot(&cell.softened::<WARM>(&e, warmed, i), &e, p.count)
    });
    each.sum()
}

pub(crate) fn settle<const WARM: bool>(
    cell: &CellGeometry,
    packets: &mut [Packet],
    warmed: &[PacketRestState],
    x: &Vectors,
) {
    for (i, packet) in packets.iter_mut().enumerate() {
        let e = cell.strains(&cell.edges(x, packet.first));
        packet.stress = cell.stress_of::<WARM>(cell.staged(e, &packet.anchor), warmed, i);
    }
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2"))]
pub(crate) fn add_forces<const WARM: bool>(
    cell: &CellGeometry,
    packets: &[Packet],
    (warmed, arms): (&[PacketRestState], &ArmStrains),
    x: &Vectors,
    v: &Vectors,
    force: &mut Vectors,
) {
    for (i, p) in packets.iter().enumerate() {
        let d = cell.edges(x, p.first);
        let mut e = cell.strains(&d);
        if cell.retardation > 0.0 {
            let rate = cell.rates(&d, &cell.edges(v, p.first));
            for k in 0..5 {
                e[k] = e[k] + rate[k] * cell.retardation;
            }
        }
        for (k, e) in e.iter_mut().enumerate() {
            arms.add_strain((5 * i + k) * LANES, &mut e.0);
        }
        cell.add_gradient(&d, &cell.stress_of::<WARM>(e, warmed, i), -1.0, (p.first, p.count), force);
    }
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2"))]
pub(crate) fn begin(cell: &CellGeometry, packets: &mut [Packet], arms: &ArmStrains, anchors: &[Anchor], follow: f64) {
    for (i, p) in packets.iter_mut().enumerate() {
        for k in 0..5 {
            p.anchor[k] = p.rate[k] * follow;
        }
        for anchor in anchors {
            let e = cell.strains(&cell.edges(anchor.x, p.first));
            for k in 0..5 {
                p.anchor[k] = p.anchor[k] + e[k] * anchor.weight;
            }
        }
        for k in 0..5 {
            arms.shift((5 * i + k) * LANES, &mut p.anchor[k].0);
        }
    }
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2"))]
pub(crate) fn add_gradient<const WARM: bool>(
    cell: &CellGeometry,
    packets: &[Packet],
    warmed: &[PacketRestState],
    x: &Vectors,
    gradient: &mut Vectors,
) {
    for (i, p) in packets.iter().enumerate() {
        let d = cell.edges(x, p.first);
        let s = cell.stress_of::<WARM>(cell.staged(cell.strains(&d), &p.anchor), warmed, i);
        cell.add_gradient(&d, &s, 1.0, (p.first, p.count), gradient);
    }
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2"))]
pub(crate) fn potential<const WARM: bool>(
    cell: &CellGeometry,
    packets: &[Packet],
    warmed: &[PacketRestState],
    x: &Vectors,
) -> f64 {
    let mut sum = 0.0;
    for (i, p) in packets.iter().enumerate() {
        let e = cell.strains(&cell.edges(x, p.first));
        sum += cell.stored_energy::<WARM>(e, warmed, i, p.count);
        if cell.viscous > 0.0 {
            let mut rate = e;
            for k in 0..5 {
                rate[k] = e[k] - p.anchor[k];
            }
            sum += cell.viscous * half_dot(&cell.softened::<WARM>(&rate, warmed, i), &rate, p.count);
        }
    }
    sum
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2"))]
pub(crate) fn add_tangent<const WARM: bool>(
    cell: &CellGeometry,
    packets: &[Packet],
    warmed: &[PacketRestState],
    x: &Vectors,
    geometric: Geometric,
    values: &mut [f64],
) {
    for (i, p) in packets.iter().enumerate() {
        let d = cell.edges(x, p.first);
        let mut s = p.stress;
        if geometric == Geometric::Clipped {
            for tension in &mut s {
                *tension = tension.positive_part();
            }
            // Shear has no sign: its geometric part is always indefinite.
            s[4] = Pack::default();
        }
        let softness = if WARM { Some(warmed[i].softness) } else { None };
        let blocks = cell.tangent(&d, &s, softness);
        for (block, slots) in blocks.iter().zip(&p.blocks) {
            block.scatter(slots, p.count, values);
        }
    }
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2"))]
pub(crate) fn predict<const WARM: bool>(
    cell: &CellGeometry,
    packets: &mut [Packet],
    warmed: &[PacketRestState],
    x: &Vectors,
    moved: &Vectors,
) -> f64 {
    let mut missed = 0.0;
    for (i, p) in packets.iter_mut().enumerate() {
        let d = cell.edges(x, p.first);
        let r = cell.edges(moved, p.first);
        let mut e = cell.strains(&d);
        let first = cell.rates(&d, &r);
        for k in 0..5 {
            e[k] = e[k] + first[k];
        }
        p.stress = cell.stress_of::<WARM>(cell.staged(e, &p.anchor), warmed, i);
        // The second-order strain is the strain of the displacement itself.
        let (a, b) = cell.middle(&r);
        let along = |k: usize, i: f64| r[k].dot(r[k]) * (0.5 * i * i);
        let second = [along(0, cell.iu), along(1, cell.iu), along(2, cell.iv), along(3, cell.iv), a.dot(b)];
        missed += (1.0 + cell.viscous) * half_dot(&cell.softened::<WARM>(&second, warmed, i), &second, p.count);
    }
    missed
}
