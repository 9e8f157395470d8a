//! Standard polyhedra: box, prism, wedge and dome. Lengths in metres.
//!
//! Sizes are unchecked; [`Polyhedron::check_closed`] rejects the result of a zero or non-finite
//! size.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::{DVec2, DVec3};

use crate::scene::polyhedron::check::MAX_CORNERS;
use crate::scene::polyhedron::{Polyhedron, PolyhedronBuilder};

impl Polyhedron {
    /// Box of this size, m, about the origin.
    pub fn cuboid(size: DVec3) -> Self {
        let half = 0.5 * size.truncate();
        let section = [
            DVec2::new(-half.x, -half.y),
            DVec2::new(half.x, -half.y),
            DVec2::new(half.x, half.y),
            DVec2::new(-half.x, half.y),
        ];
        Self::prism(&section, size.z)
    }

    /// Prism: the section (x, y), m, counter-clockwise seen from +z, extruded along z over `depth`,
    /// m, half of it to each side of z = 0.
    pub fn prism(section: &[DVec2], depth: f64) -> Self {
        let mut assembler = PolyhedronBuilder::default();
        let front: Vec<DVec3> = section.iter().map(|p| p.extend(0.5 * depth)).collect();
        let back: Vec<DVec3> = section.iter().map(|p| p.extend(-0.5 * depth)).collect();
        assembler.face(&front);
        assembler.face(&back.iter().rev().copied().collect::<Vec<_>>());
        for i in 0..section.len() {
            let next = (i + 1) % section.len();
            assembler.face(&[front[i], back[i], back[next], front[next]]);
        }
        let mut prism = assembler.take();
        // A clockwise section or a negative depth turns it inside out.
        prism.orient_outward();
        prism
    }

    /// Triangular prism on the plane y = 0 with its ridge along z: `width` along x, `height` along
    /// y and `depth` along z, all m; centred in x and z.
    pub fn wedge(width: f64, height: f64, depth: f64) -> Self {
        let half = 0.5 * width;
        Self::prism(&[DVec2::new(-half, 0.0), DVec2::new(half, 0.0), DVec2::new(0.0, height)], depth)
    }

    /// Dome of this radius, m, with a flat base on the plane y = 0 about the origin.
    ///
    /// `rings` bands of faces (1 to 1024) between base and pole, `segments` faces (3 to 1024)
    /// around; numbers outside are clamped. The vertices lie on the sphere, the faces inside it.
    pub fn hemisphere(radius: f64, rings: u32, segments: u32) -> Self {
        let limit = MAX_CORNERS as u32;
        let (rings, segments) = (rings.clamp(1, limit), segments.clamp(3, limit));
        let at = |ring: u32, segment: u32| {
            let elevation = FRAC_PI_2 * f64::from(ring) / f64::from(rings);
            let azimuth = TAU * f64::from(segment % segments) / f64::from(segments);
            // The height at the base is exactly zero, as is the sine of zero.
            let (height, reach) = elevation.sin_cos();
            radius * DVec3::new(reach * azimuth.cos(), height, reach * azimuth.sin())
        };
        let pole = DVec3::new(0.0, radius, 0.0);
        let mut assembler = PolyhedronBuilder::default();
        let base: Vec<DVec3> = (0..segments).map(|segment| at(0, segment)).collect();
        assembler.face(&base);
        for ring in 0..rings {
            for segment in 0..segments {
                let (here, there) = (at(ring, segment), at(ring, segment + 1));
                if ring + 1 == rings {
                    assembler.face(&[here, pole, there]);
                } else {
                    assembler.face(&[here, at(ring + 1, segment), at(ring + 1, segment + 1), there]);
                }
            }
        }
        let mut dome = assembler.take();
        dome.orient_outward();
        dome
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shapes_are_closed_and_have_their_volume_and_place() {
        let cuboid = Polyhedron::cuboid(DVec3::new(1.0, 2.0, 3.0));
        assert_eq!(cuboid.check_closed(), Ok(()));
        assert_eq!((cuboid.vertices.len(), cuboid.faces.len()), (8, 6));

        let wedge = Polyhedron::wedge(0.03, 0.016, 0.032);
        assert_eq!(wedge.check_closed(), Ok(()));
        assert!((wedge.volume() - 0.5 * 0.03 * 0.016 * 0.032).abs() < 1e-18);
        assert_eq!(wedge.bounds(), (DVec3::new(-0.015, 0.0, -0.016), DVec3::new(0.015, 0.016, 0.016)));
        assert_eq!((wedge.vertices.len(), wedge.faces.len()), (6, 5));

        let dome = Polyhedron::hemisphere(0.012, 8, 24);
        assert_eq!(dome.check_closed(), Ok(()));
        assert_eq!((dome.vertices.len(), dome.faces.len()), (8 * 24 + 1, 8 * 24 + 1));
        assert_eq!(dome.bounds().0.y, 0.0);
        let sphere = TAU / 3.0 * 0.012_f64.powi(3);
        let share = dome.volume() / sphere;
        assert!(share > 0.97 && share < 1.0, "{share} of the half ball");
    }

    #[test]
    fn a_fine_dome_approaches_the_half_ball() {
        let dome = Polyhedron::hemisphere(1.0, 64, 256);
        assert_eq!(dome.check_closed(), Ok(()));
        assert!((dome.volume() - TAU / 3.0).abs() < 1e-3);
        assert!(dome.vertices.iter().all(|v| (v.length() - 1.0).abs() < 1e-12));
    }

    #[test]
    fn extreme_arguments_give_something_that_the_check_judges() {
        for (rings, segments) in [(0, 0), (1, 3), (2, 1024)] {
            assert_eq!(Polyhedron::hemisphere(1.0, rings, segments).check_closed(), Ok(()), "{rings} x {segments}");
        }
        assert!(Polyhedron::hemisphere(0.0, 4, 8).check_closed().is_err());
        assert!(Polyhedron::cuboid(DVec3::new(1.0, 0.0, 1.0)).check_closed().is_err());
        assert!(Polyhedron::wedge(f64::NAN, 1.0, 1.0).check_closed().is_err());
        assert_eq!(Polyhedron::cuboid(DVec3::new(1.0, 1.0, -1.0)).check_closed(), Ok(()));
        assert!(Polyhedron::prism(&[], 1.0).check_closed().is_err());
    }
}
