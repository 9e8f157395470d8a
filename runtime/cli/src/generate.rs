//! `sheetwork generate`: a sheet from its structure and size, or a scene of playing cards.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, ValueEnum};
use glam::DVec3;
use serde_json::json;
use sheetwork::mesh::spring_class::SpringClass;
use sheetwork::mesh::structure::StructureKind;
use sheetwork::scene::sht::{self, SheetFile};
use sheetwork::scene::{InterLayerLaw, MaterialChoice, Placement, Region, RegionVector, Scene, SheetSpec};
use sheetwork::sheet::{Sheet, inter_layer, to_file};
use sheetwork::{InputError, ParameterId};
use sheetwork_rigs::card_scenes::CardScene;

use sheetwork_rigs::output::{parse_counts, print_json, print_line};
use sheetwork_rigs::quantities::{length, mass, parse_number, parse_vector, stiffness};

#[derive(Args)]
#[command(allow_negative_numbers = true)]
pub struct Generate {
    /// Structure, by name (see `sheetwork list structures`).
    #[arg(long, required_unless_present = "cards")]
    structure: Option<StructureKind>,
    /// Nodes along the length, layers, nodes along the width: 11x2x11.
    #[arg(long, value_parser = parse_counts::<3>, required_unless_present = "cards")]
    grid: Option<[u32; 3]>,
    /// Write a scene of playing cards instead: a pack that is dropped, a house, or a house with a
    /// thrown ball.
    #[arg(long, conflicts_with_all = ["structure", "grid"])]
    cards: Option<Deck>,
    /// Extent along x, m.
    #[arg(long, default_value = "0.025", value_parser = length)]
    width: f64,
    /// Extent along z, m.
    #[arg(long, default_value = "0.025", value_parser = length)]
    depth: f64,
    /// Distance between layers, m.
    #[arg(long, default_value = "0.001", value_parser = length)]
    gap: f64,
    /// Second-neighbour springs (slamm, double-diagonal, trimm).
    #[arg(long)]
    cross_over: bool,
    /// Material, by name (see `sheetwork list materials`). Without it the sheet is that of the
    /// thesis's scenes: material `thesis`, node mass 4e-5 kg, `--inter-layer "SumModulus(185)"`.
    #[arg(long)]
    material: Option<String>,
    /// Node mass, kg, in place of the material's density.
    #[arg(long, value_parser = mass)]
    node_mass: Option<f64>,
    /// Stiffness of the planar springs, N/m, in place of the material's E t.
    #[arg(long, value_parser = stiffness)]
    planar_stiffness: Option<f64>,
    /// Stiffness of the springs between layers, N/m.
    #[arg(long, value_parser = stiffness)]
    inter_layer_stiffness: Option<f64>,
    /// Law of the stiffness of the springs between layers, as in a scene: Planar, "Modulus(185)",
    /// "SumModulus(185)", "SumStiffness(1.2)".
    #[arg(long, conflicts_with = "inter_layer_stiffness")]
    inter_layer: Option<InterLayerLaw>,
    /// Dashpots along the springs, of critical damping.
    #[arg(long, default_value = "0.115", value_parser = parse_number)]
    damping: f64,
    /// Start position of the middle of the bottom layer, x,y,z in m.
    #[arg(long, default_value = "0,0,0", value_parser = parse_vector)]
    position: [f64; 3],
    /// Initial velocity, x,y,z in m/s.
    #[arg(long, default_value = "0,0,0", value_parser = parse_vector)]
    velocity: [f64; 3],
    /// Constant force on every node, x,y,z in N.
    #[arg(long, default_value = "0,0,0", value_parser = parse_vector)]
    force: [f64; 3],
    /// Acceleration of every node, x,y,z in m/s²: a column of the file that a step does not use.
    #[arg(long, default_value = "0,0,0", value_parser = parse_vector)]
    acceleration: [f64; 3],
    /// Write the sheet to a .SHT file, or the scene to a .ron file. Without it a scene goes to
    /// standard output.
    #[arg(short, long)]
    output: Option<PathBuf>,
    /// Print the counts as JSON and nothing else.
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum Deck {
    Pack,
    House,
    HouseBall,
}

impl Generate {
    pub fn execute(self) -> Result<ExitCode, InputError> {
        match (self.structure, self.grid, self.cards) {
            (Some(structure), Some(grid), _) => self.sheet(structure, grid),
            (_, _, Some(deck)) => self.write_cards(deck),
            _ => Err(InputError::new("structure", "a sheet needs its structure and its grid")),
        }
    }

    fn write_cards(&self, deck: Deck) -> Result<ExitCode, InputError> {
        let cards = match deck {
            Deck::Pack => CardScene::Pack,
            Deck::House => CardScene::House,
            Deck::HouseBall => CardScene::HouseAndBall,
        };
        let text = cards.text();
        let count = Scene::parse(&text)?.sheets.len();
        self.check_ending("ron")?;
        match &self.output {
            Some(file) => std::fs::write(file, &text).map_err(|e| InputError::io(file, &e))?,
            None if !self.json => print_line(text.trim_end())?,
            None => {}
        }
        if self.json {
            print_json(&json!({ "cards": count }))?;
        } else if self.output.is_some() {
            print_line(&format!("{count} cards"))?;
        }
        Ok(ExitCode::SUCCESS)
    }

    /// Checks that the name of the file ends in `wanted`, in small or capital letters.
    fn check_ending(&self, wanted: &str) -> Result<(), InputError> {
        let is_wrong = |file: &&PathBuf| file.extension().is_none_or(|e| !e.eq_ignore_ascii_case(wanted));
        let problem = |file: &PathBuf| format!("{} does not end in .{wanted}", file.display());
        self.output.as_ref().filter(is_wrong).map_or(Ok(()), |file| Err(InputError::new("output", problem(file))))
    }

    fn sheet(&self, structure: StructureKind, [nx, layers, nz]: [u32; 3]) -> Result<ExitCode, InputError> {
        if structure == StructureKind::Shell && self.output.is_some() {
            let problem = "shell has no springs, which a .sht file holds: describe it in a scene, structure: \"shell\"";
            return Err(InputError::new("structure", problem));
        }
        self.check_ending("sht")?;
        let check = |axis: usize| ParameterId::Gravity.check(&format!("acceleration.{axis}"), self.acceleration[axis]);
        (0..3).try_for_each(check)?;
        ParameterId::Size.check("width", self.width)?;
        ParameterId::Size.check("depth", self.depth)?;
        let scene = Scene { sheets: vec![self.spec(structure, (nx, layers, nz))?], ..Scene::default() };
        sheetwork::scene::validate::scene(&scene).map_err(unprefixed)?;
        let sheet = Sheet::build(&scene, 0)?;
        let content = self.content(&sheet);
        self.output.as_ref().map_or(Ok(()), |file| sht::write_sht_file(file, &content))?;
        let (masses, springs) = (sheet.node_count(), sheet.springs().len());
        if self.json {
            let stiffness = |inter: bool| {
                let found = content.springs.iter().find(|s| (s.kind == SpringClass::Inter) == inter);
                found.map(|s| s.stiffness)
            };
            print_json(&json!({
                "structure": structure.name(),
                "grid": format!("{nx}x{layers}x{nz}"),
                "masses": masses,
                "springs": springs,
                "mass_kg": sheet.total_mass(),
                "planar_stiffness_n_m": stiffness(false),
                "inter_layer_stiffness_n_m": stiffness(true),
                "largest_frequency_rad_s": sheet.largest_frequency(200),
            }))?;
        } else {
            print_line(&format!("{} {nx}x{layers}x{nz}: {masses} masses, {springs} springs", structure))?;
        }
        Ok(ExitCode::SUCCESS)
    }

    /// Description of the sheet by the flags.
    fn spec(&self, structure: StructureKind, grid: (u32, u32, u32)) -> Result<SheetSpec, InputError> {
        let thesis = SheetSpec::thesis();
        let choice = self.material.clone().map_or_else(|| thesis.material.clone(), MaterialChoice::Named);
        let mut material = choice.resolve(&PathBuf::new())?;
        let layered = grid.1 > 1 && structure != StructureKind::Shell;
        let is_thesis = self.material.is_none();
        let usual =
            if is_thesis && layered { InterLayerLaw::SumModulus(material.young) } else { InterLayerLaw::Planar };
        let own = self.planar_stiffness.or(self.inter_layer_stiffness).is_some();
        if let Some(stiffness) = self.planar_stiffness {
            let thickness = material.thickness;
            material.young = stiffness / thickness;
            ParameterId::MaterialYoung.check("planar_stiffness", material.young).map_err(|e| {
                let modulus = format!("{stiffness} N/m over a thickness of {thickness} m is a modulus out of range");
                InputError::new(e.field, format!("{modulus}: {}", e.problem))
            })?;
        }
        Ok(SheetSpec {
            name: "sheet".into(),
            structure,
            grid,
            size: (self.width, self.depth),
            gap: self.gap,
            material: MaterialChoice::Inline(material),
            node_mass: self.node_mass.or_else(|| is_thesis.then_some(4e-5)),
            inter_layer: self.inter_layer.unwrap_or(if own { InterLayerLaw::Planar } else { usual }),
            inter_layer_stiffness: self.inter_layer_stiffness,
            damping: self.damping,
            cross_over: self.cross_over,
            placement: Placement { position: DVec3::from(self.position), ..Placement::default() },
            velocity: DVec3::from(self.velocity),
            forces: vec![RegionVector { region: Region::All, value: DVec3::from(self.force) }],
            ..thesis
        })
    }

    /// Content of the file: that of the sheet, with the numbers of the flags to the last digit.
    fn content(&self, sheet: &Sheet) -> SheetFile {
        let mut content = to_file(sheet);
        content.masses.iter_mut().for_each(|m| m.acceleration = DVec3::from(self.acceleration));
        let follows = inter_layer::own_stiffness(sheet).is_none();
        for spring in content.springs.iter_mut().filter(|s| follows || s.kind != SpringClass::Inter) {
            spring.stiffness = self.planar_stiffness.unwrap_or(spring.stiffness);
        }
        content
    }
}

/// Removes the scene's path from a field name, because flags are not part of a scene.
fn unprefixed(error: InputError) -> InputError {
    InputError { field: error.field.replacen("sheets.0.", "", 1), ..error }
}
