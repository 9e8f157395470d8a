//! Wind zones of a running world. They are part of a snapshot; a reset returns to those of the
//! scene.

use crate::error::InputError;
use crate::parallel::*;
use crate::rigid::RigidView;
use crate::scene::{WindZone, validate};
use crate::sheet::Sheet;
use crate::sheet::wind::{WindField, WindStep};
use crate::world::World;

/// Zones as a step evaluates them; `None` without zones.
pub(super) fn field_of(zones: &[WindZone]) -> Option<Box<WindField>> {
    (!zones.is_empty()).then(|| Box::new(WindField::new(zones)))
}

impl World {
    /// Wind zones.
    pub fn wind_zones(&self) -> &[WindZone] {
        &self.wind_zones
    }

    /// Replace all wind zones, from the next step on; sheets wake.
    ///
    /// # Errors
    /// When a value is out of range; nothing changes then.
    pub fn set_wind_zones(&mut self, zones: &[WindZone]) -> Result<(), InputError> {
        validate::wind_zones(zones)?;
        self.wind_zones = zones.to_vec();
        self.wind = field_of(zones);
        for sheet in &mut self.sheets {
            sheet.parameters.drag.take_nodes();
            sheet.wake();
        }
        Ok(())
    }

    /// Evaluate the air of the zones at the nodes of the sheets for a step of `dt` (s).
    pub(super) fn update_wind(&mut self, view: Option<&RigidView>, dt: f64) {
        let Some(mut wind) = self.wind.take() else { return };
        wind.begin_step(view);
        let step = WindStep { field: self.field(), time: self.time, dt, view };
        let Self { sheets, pool, .. } = self;
        match pool {
            Some(pool) if sheets.len() > 1 => {
                pool.install(|| sheets.par_iter_mut().for_each(|sheet| wind.update_sheet(sheet, &step)));
            }
            _ => sheets.iter_mut().for_each(|sheet: &mut Sheet| wind.update_sheet(sheet, &step)),
        }
        self.wind = Some(wind);
    }
}
