//! Flags of the thermal rigs of `sheetwork measure`.

use clap::Args;
use glam::DVec3;
use sheetwork_rigs::measure::Thermal;
use sheetwork_rigs::quantities::{convection, parse_number, parse_vector, temperature, time};

#[derive(Args)]
pub struct HeatFlags {
    /// Corners of the polygon, m: "x,y,z;x,y,z;..." (view-factor).
    #[arg(long, value_parser = polygon, allow_hyphen_values = true)]
    polygon: Option<Polygon>,
    /// Position of the patch, m: x,y,z (view-factor).
    #[arg(long, default_value = "0,0,0", value_parser = vector, allow_hyphen_values = true)]
    point: DVec3,
    /// Normal of the patch: x,y,z (view-factor).
    #[arg(long, default_value = "0,1,0", value_parser = vector, allow_hyphen_values = true)]
    normal: DVec3,
    /// Fourier number: diffusivity times time over the length squared (conduction).
    #[arg(long, default_value = "0.1", value_parser = parse_number)]
    fo: f64,
    /// Initial temperature, °C (cooling: default 120; radiate: that of the surroundings).
    #[arg(long, value_parser = temperature)]
    from: Option<f64>,
    /// Final temperature, °C (cooling).
    #[arg(long, default_value = "60", value_parser = temperature)]
    to: f64,
    /// Temperature of the surroundings, °C (cooling, radiate).
    #[arg(long, default_value = "20", value_parser = temperature)]
    ambient: f64,
    /// Convection coefficient, sum of both sides, W/(m² K) (cooling, radiate).
    #[arg(long, default_value = "0", value_parser = convection)]
    convection: f64,
    /// Temperature of the black heater, °C (radiate).
    #[arg(long, default_value = "400", value_parser = temperature)]
    heater: f64,
    /// View factor of the heater from one side (radiate).
    #[arg(long, default_value = "0.5", value_parser = parse_number)]
    view: f64,
    /// Duration, s (default 60 for radiate, 10 for creep).
    #[arg(long, value_parser = time)]
    pub seconds: Option<f64>,
    /// Temperature of the sheet, °C (default 100 for softening; for creep 40 K above the glass
    /// transition, or 20 without one).
    #[arg(long, value_parser = temperature)]
    pub celsius: Option<f64>,
}

/// A polygon as one type, because clap treats a plain `Vec` as a list of arguments.
#[derive(Clone)]
struct Polygon(Vec<DVec3>);

impl HeatFlags {
    pub fn thermal(&self) -> Thermal {
        Thermal {
            polygon: self.polygon.as_ref().map_or_else(|| Thermal::default().polygon, |p| p.0.clone()),
            point: self.point,
            normal: self.normal,
            fourier: self.fo,
            from: self.from,
            to: self.to,
            ambient: self.ambient,
            convection: self.convection,
            heater: self.heater,
            view: self.view,
            seconds: self.seconds.unwrap_or(60.0),
            celsius: self.celsius.unwrap_or(100.0),
        }
    }
}

/// Parses three numbers separated by commas.
fn vector(text: &str) -> Result<DVec3, String> {
    parse_vector(text).map(DVec3::from_array)
}

fn polygon(text: &str) -> Result<Polygon, String> {
    text.split(';').filter(|p| !p.trim().is_empty()).map(vector).collect::<Result<_, _>>().map(Polygon)
}
