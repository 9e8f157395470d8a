//! Table of the structures.

use crate::mesh::spring_class::SpringClass;
use crate::mesh::structure::{LatticeBuilder, Structure, StructureKind};

/// Families of springs in a layer: offset in the grid, and class.
const X: (i32, i32, SpringClass) = (1, 0, SpringClass::X);
const Z: (i32, i32, SpringClass) = (0, 1, SpringClass::Z);
const DIAGONAL: (i32, i32, SpringClass) = (1, 1, SpringClass::Diagonal);
const ANTI_DIAGONAL: (i32, i32, SpringClass) = (-1, 1, SpringClass::AntiDiagonal);

/// Structure of square cells with 1 to 64 layers; other properties are set in [`TABLE`].
const fn row(
    kind: StructureKind,
    name: &'static str,
    about: &'static str,
    connect: fn(&mut LatticeBuilder),
) -> Structure {
    Structure { kind, name, about, layers: (1, 64), triangular: false, flexion: false, cross_over: false, connect }
}

/// All structures, in the order of menus.
pub const TABLE: &[Structure] = &[
    // SaMM, the square mesh (thesis 4.4.2): springs along x and z, layers joined at the four
    // corners of each cell. No spring resists shear or twist within a layer: a strip bends, a plate
    // folds along its diagonals.
    row(StructureKind::Samm, "samm", "square mesh, layers joined by four springs a mass", |lattice| {
        lattice.families(&[X, Z]);
        lattice.inter_layer();
    }),
    // SLaMM, the square-lattice mesh (thesis 4.4.2): SaMM with one diagonal per cell, in the same
    // direction in all cells. The single diagonal couples bending with twist, which the thesis
    // describes as a yaw distortion.
    Structure {
        cross_over: true,
        ..row(StructureKind::Slamm, "slamm", "samm with one diagonal a cell", |lattice| {
            lattice.families(&[X, Z, DIAGONAL]);
            lattice.inter_layer();
            lattice.cross_over(&[(2, 0), (0, 2), (2, 2)]);
        })
    },
    // SLaMM with a second diagonal: proposed by the thesis (5.3.4) to remove the distortion of the
    // single one.
    Structure {
        cross_over: true,
        ..row(StructureKind::DoubleDiagonal, "double-diagonal", "samm with both diagonals of each cell", |lattice| {
            lattice.families(&[X, Z, DIAGONAL, ANTI_DIAGONAL]);
            lattice.inter_layer();
            lattice.cross_over(&[(2, 0), (0, 2), (2, 2), (-2, 2)]);
        })
    },
    // TRiMM, the triangular mesh (thesis 4.4.2): every other row is shifted by half a cell, so that
    // layers consist of triangles; layers are joined at the three corners of the triangle below
    // each node. With rows at √3/2 of the spacing the triangles are equilateral and the layer is
    // isotropic.
    Structure {
        triangular: true,
        cross_over: true,
        ..row(StructureKind::Trimm, "trimm", "triangular mesh, layers joined by three springs a mass", |lattice| {
            lattice.families(&[X]);
            lattice.slants();
            lattice.inter_layer();
            // Two rows further the shift repeats, and a slanting line has moved by one column.
            lattice.cross_over(&[(2, 0), (1, 2), (-1, 2)]);
        })
    },
    // Provot's cloth (Provot 1995; thesis 6.2): one layer with structural, shear and flexion
    // springs, and an optional limit on the angle between a spring and the next in line.
    Structure {
        layers: (1, 1),
        flexion: true,
        ..row(
            StructureKind::Provot2d,
            "provot2d",
            "Provot's single layer: structural, shear and flexion springs",
            |lattice| {
                lattice.families(&[X, Z, DIAGONAL, ANTI_DIAGONAL]);
                lattice.flexion(&[(2, 0), (0, 2)]);
            },
        )
    },
    // Hybrid structure of the thesis (thesis 6.2): double-diagonal layers joined as in SaMM, with
    // Provot's flexion springs in each layer. The thesis's user study preferred it.
    Structure {
        layers: (2, 64),
        flexion: true,
        ..row(
            StructureKind::Provot3d,
            "provot3d",
            "double-diagonal layers with Provot's flexion springs in each",
            |lattice| {
                lattice.families(&[X, Z, DIAGONAL, ANTI_DIAGONAL]);
                lattice.inter_layer();
                lattice.flexion(&[(2, 0), (0, 2)]);
            },
        )
    },
    // Provot's springs in the triangular mesh (thesis 7.3 a and 7.4 iii): flexion springs to second
    // neighbours along the three directions of each triangular layer. The springs of a triangle
    // resist shear, so that no shear springs are needed, and a layer bends alike in its three
    // directions.
    Structure {
        layers: (2, 64),
        triangular: true,
        flexion: true,
        ..row(
            StructureKind::ProvotTrimm,
            "provot-trimm",
            "trimm with Provot's flexion springs in each layer",
            |lattice| {
                lattice.families(&[X]);
                lattice.slants();
                lattice.inter_layer();
                lattice.flexion(&[(2, 0), (1, 2), (-1, 2)]);
            },
        )
    },
    // Shell: one layer of nodes without springs. Its membrane and bending elements are finite
    // differences of a continuous sheet (`elements/grid_membrane`, `elements/bending`), with the
    // stiffness of the material on any grid.
    Structure {
        layers: (1, 1),
        ..row(
            StructureKind::Shell,
            "shell",
            "one layer with the true membrane and bending stiffness of its material",
            |_| {},
        )
    },
];
