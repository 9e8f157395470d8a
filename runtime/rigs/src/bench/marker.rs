//! Markers of points: colour by structure or peer, shape by integrator or settings of the peer.
//! Peers have shapes of their own.

use plotters::style::RGBColor;

use crate::bench::point::ParetoPoint;
use crate::bench::sweep::EQUAL_SPRINGS;

/// Outline of a marker.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MarkerShape {
    Disc,
    Square,
    Diamond,
    Hexagon,
    Cross,
    TriangleUp,
    TriangleDown,
    Star,
    Kite,
    Bar,
}

impl MarkerShape {
    /// Corners about the origin of a marker of radius `r`, units of the drawing; all shapes have
    /// about the same area.
    pub fn outline(self, r: f64) -> Vec<(f64, f64)> {
        let ring = |corners: u32, radius: &dyn Fn(u32) -> f64, turn: f64| {
            let angle = move |k: u32| std::f64::consts::TAU * (f64::from(k) + turn) / f64::from(corners);
            (0..corners).map(|k| (radius(k) * angle(k).sin(), -radius(k) * angle(k).cos())).collect()
        };
        match self {
            Self::Disc => ring(20, &|_| r, 0.0),
            Self::Square => ring(4, &|_| 1.25 * r, 0.5),
            Self::Diamond => ring(4, &|_| 1.3 * r, 0.0),
            Self::Hexagon => ring(6, &|_| 1.1 * r, 0.5),
            Self::Cross => {
                let (a, b) = (0.42 * r, 1.2 * r);
                let quarter = [(-a, -b), (a, -b), (a, -a)];
                [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)]
                    .into_iter()
                    .flat_map(|(cos, sin)| quarter.map(|(x, y)| (cos * x - sin * y, sin * x + cos * y)))
                    .collect()
            }
            Self::TriangleUp => ring(3, &|_| 1.55 * r, 0.0),
            Self::TriangleDown => ring(3, &|_| 1.55 * r, 0.5),
            Self::Kite => vec![(0.0, -1.7 * r), (0.95 * r, 0.2 * r), (0.0, 1.1 * r), (-0.95 * r, 0.2 * r)],
            Self::Bar => vec![(-1.5 * r, -0.65 * r), (1.5 * r, -0.65 * r), (1.5 * r, 0.65 * r), (-1.5 * r, 0.65 * r)],
            Self::Star => ring(10, &|k| if k % 2 == 0 { 1.6 * r } else { 0.75 * r }, 0.0),
        }
    }
}

/// Colour and shape of a marker.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MarkerStyle {
    pub colour: RGBColor,
    pub shape: MarkerShape,
}

const GREY: RGBColor = RGBColor(87, 96, 106);

/// Colours that colour-blind readers can distinguish (Okabe and Ito 2008), darkened for a white
/// background.
const STRUCTURES: &[(&str, RGBColor)] = &[
    ("shell", RGBColor(0, 92, 170)),
    ("double-diagonal", RGBColor(0, 140, 100)),
    ("trimm", RGBColor(60, 170, 215)),
    ("slamm", RGBColor(170, 150, 20)),
    ("samm", RGBColor(150, 120, 90)),
    ("equal springs", RGBColor(120, 20, 30)),
];
const ENGINES: &[(&str, MarkerShape)] = &[
    ("tr-bdf2", MarkerShape::Disc),
    ("bdf2", MarkerShape::Diamond),
    ("backward-euler", MarkerShape::Square),
    ("verlet", MarkerShape::Cross),
    ("rk4", MarkerShape::Hexagon),
];
const PEERS: &[RGBColor] = &[RGBColor(205, 80, 0), RGBColor(170, 50, 140), RGBColor(90, 90, 90)];
const PEER_SHAPES: &[MarkerShape] =
    &[MarkerShape::TriangleUp, MarkerShape::TriangleDown, MarkerShape::Star, MarkerShape::Kite, MarkerShape::Bar];

/// One entry of the legend.
pub struct Entry {
    pub name: String,
    pub look: MarkerStyle,
}

/// Entries of the legend: structures, integrators, peers, each in the order of its table or of
/// appearance.
pub struct MarkerStyles {
    pub structures: Vec<Entry>,
    pub engines: Vec<Entry>,
    pub peers: Vec<Entry>,
}

impl MarkerStyles {
    /// Entries for everything that occurs in `points`.
    pub fn new(points: &[ParetoPoint]) -> Self {
        let ours = |key: fn(&ParetoPoint) -> &str, name: &str| points.iter().any(|p| !p.peer && key(p) == name);
        let structures = STRUCTURES.iter().filter(|(name, _)| ours(key_of_structure, name));
        let engines = ENGINES.iter().filter(|(name, _)| ours(|p| &p.engine, name));
        let mut seen: Vec<&str> = Vec::new();
        let mut peers: Vec<Entry> = Vec::new();
        for point in points.iter().filter(|p| p.peer) {
            let name = of_peer(point);
            if peers.iter().any(|e| e.name == name) {
                continue;
            }
            let which = seen.iter().position(|s| *s == point.structure).unwrap_or_else(|| {
                seen.push(&point.structure);
                seen.len() - 1
            });
            let look =
                MarkerStyle { colour: PEERS[which % PEERS.len()], shape: PEER_SHAPES[peers.len() % PEER_SHAPES.len()] };
            peers.push(Entry { name, look });
        }
        let entry = |name: &str, colour, shape| Entry { name: name.into(), look: MarkerStyle { colour, shape } };
        Self {
            structures: structures.map(|&(name, colour)| entry(name, colour, MarkerShape::Disc)).collect(),
            engines: engines.map(|&(name, shape)| entry(name, GREY, shape)).collect(),
            peers,
        }
    }

    /// Rows of the legend with entries.
    pub fn rows(&self) -> impl Iterator<Item = (&'static str, &[Entry])> {
        let rows: [(_, &[Entry]); 3] =
            [("structure", &self.structures), ("engine", &self.engines), ("peers", &self.peers)];
        rows.into_iter().filter(|(_, entries)| !entries.is_empty())
    }

    /// Marker of a point.
    pub fn look(&self, point: &ParetoPoint) -> MarkerStyle {
        let find = |entries: &[Entry], name: &str| entries.iter().find(|e| e.name == name).map(|e| e.look);
        if point.peer {
            return find(&self.peers, &of_peer(point))
                .unwrap_or(MarkerStyle { colour: GREY, shape: MarkerShape::Star });
        }
        let colour = find(&self.structures, key_of_structure(point)).map_or(GREY, |l| l.colour);
        let shape = find(&self.engines, &point.engine).map_or(MarkerShape::Disc, |l| l.shape);
        MarkerStyle { colour, shape }
    }
}

/// Name of a structure in the legend: one for all lattices of equal springs.
fn key_of_structure(point: &ParetoPoint) -> &str {
    if point.structure.ends_with(EQUAL_SPRINGS) { "equal springs" } else { &point.structure }
}

/// Name of a peer in the legend.
fn of_peer(point: &ParetoPoint) -> String {
    format!("{}: {}", point.structure, point.engine)
}
