//! `sheetwork generate`: a sheet from its structure and size, or a scene of playing cards.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, ValueEnum};
use serde_json::json;
use sheetwork::mesh::structure::StructureKind;
use sheetwork::scene::{MaterialChoice, Scene, SheetSpec, sht};
use sheetwork::sheet::{Sheet, to_file};
use sheetwork::{InputError, ParameterId};
use sheetwork_rigs::card_scenes::CardScene;

use sheetwork_rigs::output::{parse_counts, print_json, print_line};
use sheetwork_rigs::quantities::{length, mass};

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
    /// Material, by name (see `sheetwork list materials`).
    #[arg(long, default_value = "thesis")]
    material: String,
    /// Node mass, kg, in place of the material's density.
    #[arg(long, value_parser = mass)]
    node_mass: Option<f64>,
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

    fn sheet(&self, structure: StructureKind, [nx, layers, nz]: [u32; 3]) -> Result<ExitCode, InputError> {
        ParameterId::Size.check("width", self.width)?;
        ParameterId::Size.check("depth", self.depth)?;
        let spec = SheetSpec {
            name: "sheet".into(),
            structure,
            grid: (nx, layers, nz),
            size: (self.width, self.depth),
            gap: self.gap,
            material: MaterialChoice::Named(self.material.clone()),
            node_mass: self.node_mass,
            cross_over: self.cross_over,
            ..SheetSpec::thesis()
        };
        let scene = Scene { sheets: vec![spec], ..Scene::default() };
        sheetwork::scene::validate::scene(&scene).map_err(unprefixed)?;
        let sheet = Sheet::build(&scene, 0)?;
        let (masses, springs) = (sheet.node_count(), sheet.springs().len());
        if let Some(file) = &self.output {
            sht::write_sht_file(file, &to_file(&sheet))?;
        }
        if self.json {
            print_json(&json!({
                "structure": structure.name(),
                "grid": format!("{nx}x{layers}x{nz}"),
                "masses": masses,
                "springs": springs,
                "mass_kg": sheet.total_mass(),
            }))?;
        } else {
            print_line(&format!("{} {nx}x{layers}x{nz}: {masses} masses, {springs} springs", structure))?;
        }
        Ok(ExitCode::SUCCESS)
    }
}

/// Removes the scene's path from a field name, because flags are not part of a scene.
fn unprefixed(mut error: InputError) -> InputError {
    if let Some(field) = error.field.strip_prefix("sheets.0.") {
        error.field = field.to_owned();
    }
    error
}
