//! Command line of the editor.

mod run;

use std::path::PathBuf;

use bevy_sheetwork::{SheetColour, SheetLayer};
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Parser, ValueEnum};
use sheetwork::InputError;
use sheetwork::sheet::surface::SurfaceSmoothing;

use crate::panels::{Display, EditorState, Section, Tool, blind};
use crate::scenes;
use crate::session::{Session, Variant};
use crate::study::Study;

/// Watch stiff thin sheets fall, bend and slide, and edit them at run time.
///
/// Opens a window. Without a display or a Vulkan driver the scene runs headless instead, and leaves
/// a picture and a recording.
#[derive(Clone, Debug, Default, Parser)]
#[command(name = "sheetwork-editor", version)]
pub struct Arguments {
    /// Scene file, the name of one in assets/scenes, or a recording (.swr); `wedge_stiff` by
    /// default.
    pub scene: Option<PathBuf>,
    /// Override a field of the scene, as in `--set sheets.0.material.young=900`; may be repeated.
    #[arg(long, value_name = "PATH=VALUE")]
    pub set: Vec<String>,
    /// Render one frame offscreen to this PNG file and exit.
    #[arg(long, value_name = "FILE")]
    pub screenshot: Option<PathBuf>,
    /// Simulated time of the screenshot, s, from 0; the scene's duration by default. With several
    /// times, as in `--at 1,5`, one picture per time, one below the other.
    #[arg(long, value_name = "SECONDS", requires = "screenshot", value_delimiter = ',')]
    pub at: Vec<f64>,
    /// Add a picture of the scene with a field overridden beside it, as in `--beside engine=rk4`;
    /// may be repeated.
    #[arg(long, value_name = "PATH=VALUE", requires = "screenshot")]
    pub beside: Vec<String>,
    /// Run the scene without a window and write a picture of every moment to this folder:
    /// frame_0000.png and so on.
    #[arg(long, value_name = "FOLDER", conflicts_with_all = ["screenshot", "headless", "study"])]
    pub sequence: Option<PathBuf>,
    /// Run the scene without a window and write it as binary glTF: sheets as morph targets, bodies
    /// as animated nodes.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["screenshot", "headless", "study"])]
    pub gltf: Option<PathBuf>,
    /// Moments per simulated second of --sequence and --gltf, 0.01 to 10000.
    #[arg(long, value_name = "N", default_value_t = crate::export::RATE)]
    pub rate: f64,
    /// Write the pictures of docs/editor.md to this folder and exit; every panel is in one of them.
    #[arg(long, value_name = "FOLDER", conflicts_with_all = ["screenshot", "headless", "sequence", "gltf"])]
    pub pictures: Option<PathBuf>,
    /// Write only pictures whose names contain this.
    #[arg(long, value_name = "PART", requires = "pictures")]
    pub only: Option<String>,
    /// Size of the picture or the window, pixels.
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub size: Option<(u32, u32)>,
    /// Include the panels in the screenshot.
    #[arg(long, requires = "screenshot")]
    pub with_ui: bool,
    /// Show a variant of the scene with a field overridden, at the same time, as in `--compare
    /// engine=rk4`; up to three times.
    #[arg(long, value_name = "PATH=VALUE")]
    pub compare: Vec<String>,
    /// Open sections of the controls, in window and screenshot; `all` for all of them.
    #[arg(long, value_name = "SECTION", value_delimiter = ',', value_parser = sections())]
    pub open: Vec<Sections>,
    /// Start a study: blind trials of sheets in the order of this seed (1 by default), with a
    /// questionnaire; a screenshot shows the first with its questions. `sheetwork study` evaluates
    /// the answers.
    #[arg(long, value_name = "ORDER", num_args = 0..=1, default_missing_value = "1", conflicts_with = "headless")]
    pub study: Option<u64>,
    /// Show plots below the view; in a screenshot with the phases of a step.
    #[arg(long)]
    pub plots: bool,
    /// Open the window paused.
    #[arg(long, conflicts_with_all = ["screenshot", "headless"])]
    pub paused: bool,
    /// Use light panels.
    #[arg(long)]
    pub light: bool,
    /// Tool of the left button.
    #[arg(long, value_name = "TOOL")]
    pub tool: Option<Tool>,
    /// Additional items to draw, in window and screenshot.
    #[arg(long, value_name = "WHAT", value_delimiter = ',')]
    pub show: Vec<Show>,
    /// Field that colours the sheets; by default the heat of a scene that has any.
    #[arg(long, value_name = "BY", value_parser = colour())]
    pub colour: Option<SheetColour>,
    /// Temperatures of the darkest and the brightest colour, °C, -273.15 to 5000; by default from
    /// the scene.
    #[arg(long, value_name = "LOW,HIGH", value_parser = range, allow_hyphen_values = true)]
    pub celsius: Option<(f32, f32)>,
    /// Run without a window: print the report, write a picture and a recording to sheetwork-out/.
    #[arg(long, conflicts_with = "screenshot")]
    pub headless: bool,
    /// Duration of a run without a window, simulated s; the scene's duration by default.
    #[arg(long, value_name = "S")]
    pub seconds: Option<f64>,
    /// Close the window this number of frames after the scene was first shown, and print the time
    /// of that.
    #[arg(long, value_name = "N", hide = true)]
    pub frames: Option<u32>,
}

/// Item that can be drawn of the sheets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Show {
    /// Springs, coloured by strain.
    Springs,
    /// Nodes.
    Masses,
    /// Surface of the bottom layer in place of the top layer.
    Bottom,
    /// Flat surface between the nodes.
    Flat,
    /// B-spline surface with the nodes as control points.
    BSpline,
    /// Bézier surface with the nodes as control points.
    Bezier,
    /// No surface.
    Bare,
}

/// Sections of the controls: one, or all.
type Sections = Vec<Section>;

fn sections() -> impl TypedValueParser<Value = Sections> {
    let all = || Section::ALL.into_iter().map(|(section, _)| section);
    let names = all().filter_map(|section| section.to_possible_value());
    let parser = PossibleValuesParser::new(names.chain([PossibleValue::new("all").help("Every one")]));
    parser.map(move |name| Section::from_str(&name, false).map_or_else(|_| all().collect(), |one| vec![one]))
}

/// Fields that can colour the sheets, with their names and descriptions.
const COLOURS: [(&str, &str, SheetColour); 7] = [
    ("plain", "None: one colour", SheetColour::Plain),
    ("temperature", "Temperature", SheetColour::Temperature),
    ("stiffness", "Remaining stiffness", SheetColour::Stiffness),
    ("stretch", "Strain", SheetColour::Stretch),
    ("bending", "Curvature", SheetColour::Bending),
    ("speed", "Speed", SheetColour::Speed),
    ("contact", "Contact force", SheetColour::Contact),
];

fn colour() -> impl TypedValueParser<Value = SheetColour> {
    let parser = PossibleValuesParser::new(COLOURS.map(|(name, about, _)| PossibleValue::new(name).help(about)));
    parser.map(|name| COLOURS.into_iter().find(|row| row.0 == name).map_or(SheetColour::Plain, |row| row.2))
}

/// Parse `20,120`.
fn range(text: &str) -> Result<(f32, f32), String> {
    let wrong = || format!("\"{text}\" is not a range like 20,120, -273.15 to 5000 °C, the lower first");
    let (low, high) = text.split_once(',').ok_or_else(wrong)?;
    let end = |s: &str| s.trim().parse().ok().filter(|t: &f32| (-273.15..=5000.0).contains(t)).ok_or_else(wrong);
    let (low, high) = (end(low)?, end(high)?);
    if low < high { Ok((low, high)) } else { Err(wrong()) }
}

/// Parse `1280x720`.
fn size(text: &str) -> Result<(u32, u32), String> {
    let wrong = || format!("\"{text}\" is not a size like 1280x720, 16x16 to 8192x8192 pixels");
    let (width, height) = text.split_once(['x', 'X']).ok_or_else(wrong)?;
    let side = |s: &str| s.trim().parse().ok().filter(|n| (16..=8192).contains(n)).ok_or_else(wrong);
    Ok((side(width)?, side(height)?))
}

impl Arguments {
    /// Path of the scene file.
    pub fn scene_file(&self) -> PathBuf {
        let name = self.scene.clone().unwrap_or_else(|| scenes::FIRST_SCENE.into());
        scenes::find(&name)
    }

    /// Initial display settings.
    pub fn display(&self) -> Display {
        let asked = |what| self.show.contains(&what);
        Display {
            surface: !asked(Show::Bare),
            layer: if asked(Show::Bottom) { SheetLayer::Bottom } else { SheetLayer::Top },
            smooth: !asked(Show::Flat),
            spline: if asked(Show::Bezier) {
                SurfaceSmoothing::Bezier
            } else if asked(Show::BSpline) {
                SurfaceSmoothing::BSpline
            } else {
                SurfaceSmoothing::Interpolating
            },
            colour: self.sheet_colour(),
            springs: asked(Show::Springs),
            nodes: asked(Show::Masses),
            ..Display::default()
        }
    }

    /// Initial state of the panels.
    pub fn state(&self, session: &Session) -> EditorState {
        let mut state = EditorState {
            display: self.display().for_session(session),
            light: self.light,
            ..EditorState::new(session)
        };
        state.plots.shown = self.plots;
        state.plots.stages = self.plots && self.screenshot.is_some();
        state.study = self
            .study
            .map(|order| if self.screenshot.is_some() { Study::for_picture(order) } else { Study::new(order) });
        if state.is_blind() {
            state.display = blind();
        }
        if !self.open.is_empty() {
            state.open_sections = self.open.concat().into_iter().collect();
        }
        state.tool = self.tool.unwrap_or_default();
        if state.tool == Tool::Move {
            state.selected = session.items().last().copied();
        }
        state
    }

    /// Requested field that colours the sheets.
    pub fn sheet_colour(&self) -> Option<SheetColour> {
        match (self.colour, self.celsius) {
            (None | Some(SheetColour::Temperature), Some((low, high))) => {
                Some(SheetColour::TemperatureBetween { low, high })
            }
            (colour, _) => colour,
        }
    }

    /// Variants of the comparison.
    ///
    /// # Errors
    /// When an argument is not `PATH=VALUE`.
    pub fn variants(&self) -> Result<Vec<Variant>, InputError> {
        let variant = |text: &String| {
            let parts = text.split_once('=').map(|(path, value)| (path.trim().to_owned(), value.trim().to_owned()));
            let (path, value) =
                parts.ok_or_else(|| InputError::new("--compare", format!("\"{text}\" is not PATH=VALUE")))?;
            Ok(Variant { path, value })
        };
        self.compare.iter().map(variant).collect()
    }

    /// Add the variants of the comparison to the session.
    ///
    /// # Errors
    /// When an argument is not `PATH=VALUE`, or its field or value is invalid.
    pub fn compare(&self, session: &mut Session) -> Result<(), InputError> {
        let variants = self.variants()?;
        if variants.is_empty() {
            return Ok(());
        }
        session.compare_with(variants);
        let wrong = session.variants().find_map(|(variant, made)| made.err().map(|why| (variant, why.to_owned())));
        match wrong {
            Some((variant, why)) => Err(InputError::new(format!("--compare {}={}", variant.path, variant.value), why)),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        Arguments::command().debug_assert();
        let parse = |line: &str| Arguments::try_parse_from(line.split(' '));
        let display = parse("x --show springs,masses --show flat").expect("valid").display();
        assert!(display.springs && display.nodes && display.surface && !display.smooth);
        let shot = parse("x wedge --screenshot a.png --at 1.5 --size 640x360").expect("valid");
        assert_eq!((shot.size, shot.at.clone()), (Some((640, 360)), vec![1.5]));
        let several = parse("x --screenshot a.png --at 1,5 --beside dt=0.01 --beside engine=rk4").expect("valid");
        assert_eq!((several.at, several.beside.len()), (vec![1.0, 5.0], 2));
        assert!(parse("x --at 1").is_err(), "--at without --screenshot");
        assert!(parse("x --headless --screenshot a.png").is_err());
        for bad in ["640", "axb", "0x10", "9999x20", "-4x20"] {
            assert!(parse(&format!("x --size={bad}")).is_err(), "{bad}");
        }
        let colour = |line: &str| parse(line).expect("valid").sheet_colour();
        assert_eq!(colour("x"), None);
        assert_eq!(colour("x --colour stiffness"), Some(SheetColour::Stiffness));
        let between = SheetColour::TemperatureBetween { low: -10.0, high: 90.5 };
        assert_eq!(colour("x --celsius -10,90.5"), Some(between));
        for bad in ["20", "90,20", "a,b", "-300,20", "20,9999"] {
            assert!(parse(&format!("x --celsius={bad}")).is_err(), "{bad}");
        }
    }
}
