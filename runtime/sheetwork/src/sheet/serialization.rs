//! Serialisation of a sheet for snapshots: parameters that can change during a run, and state that
//! a step takes from earlier steps.
//!
//! Topology, node masses and rest shape follow from the scene and are not serialised, nor is the
//! workspace of a step. Elements serialise their rates and stresses while an implicit integrator
//! runs, and their law where temperature, creep, plasticity or fracture have changed it.

use glam::DVec3;

use crate::elements::Element;
use crate::elements::grab_spring::GrabSpring;
use crate::scene::{Material, WhenUnstable, validate};
use crate::serialize::{CorruptState, ReadResult, StateReader, StateWriter};
use crate::sheet::bonds::AdhesionState;
use crate::sheet::{Field, ImplicitSystem, Interpenetration, RecoveryState, Sheet, Status};

impl Sheet {
    /// Serialise the layout that a snapshot must match.
    pub(crate) fn serialise_layout(&self, to: &mut StateWriter) {
        to.text(&self.name);
        let own = self.elements.len() - self.grabs.len();
        for count in [self.node_count(), self.springs.len(), own, self.layers.len()] {
            to.count(count as u64);
        }
        to.count(self.open_cells().map_or(0, <[bool]>::len) as u64);
        to.flag(self.inelastic.is_some());
    }

    /// Whether steps have changed the law of its elements or its open cells.
    pub(crate) fn is_changed(&self) -> bool {
        self.heat.is_some() || self.inelastic.is_some() || self.open_count() > 0
    }

    /// Serialise the parameters that can change during a run.
    pub(crate) fn serialise_settings(&self, to: &mut StateWriter) {
        serialise_material(&self.material, to);
        to.numbers(&[self.friction, self.restitution, self.spring_parameters.damping, self.damping_ratio]);
        to.optional(self.flexion_angle_limit());
        self.drag.serialise_settings(to);
        to.optional(self.inelastic.as_ref().map(|f| f.celsius()));
        to.text(self.chosen_engine().name());
        self.when_unstable().serialise(to);
        to.number(self.max_step);
        self.applied.axes().into_iter().for_each(|axis| to.sparse(axis));
        to.count(self.grabs.len() as u64);
        self.grabs.iter().for_each(|pull| pull.serialise(to));
    }

    /// Deserialise the parameters; `tolerance` is that of an adaptive integrator, m.
    pub(crate) fn deserialise_settings(&mut self, from: &mut StateReader, tolerance: f64) -> ReadResult {
        let material = deserialise_material(from)?;
        (self.friction, self.restitution) = (from.number()?, from.number()?);
        let (damping, ratio) = (from.number()?, from.number()?);
        if (damping, ratio) != (self.spring_parameters.damping, self.damping_ratio) {
            (self.spring_parameters.damping, self.damping_ratio) = (damping, ratio);
            self.refresh();
        }
        if material != self.material {
            self.set_material(material).map_err(|_| CorruptState)?;
        }
        let limit = from.optional()?;
        if limit != self.flexion_angle_limit() {
            self.set_flexion_limit(limit).map_err(|_| CorruptState)?;
        }
        self.drag.deserialise_settings(from)?;
        let celsius = from.optional()?;
        if let Some((flow, celsius)) = self.inelastic.as_mut().zip(celsius) {
            flow.set_celsius(celsius);
        }
        let engine = from.text()?.parse().map_err(|_| CorruptState)?;
        if engine != self.chosen_engine() {
            self.set_engine(engine, tolerance);
        }
        self.engine.set_tolerance(tolerance);
        let policy = WhenUnstable::deserialise(from)?;
        if policy != self.when_unstable() {
            self.set_recovery_policy(policy, tolerance);
        }
        self.recovery.iter_mut().for_each(|guard| guard.tolerance = tolerance);
        self.max_step = from.number()?;
        // A shorter step than 1e-9 s would need an unbounded number of substeps.
        if self.max_step.is_nan() || self.max_step < 1e-9 {
            return Err(CorruptState);
        }
        self.applied.axes_mut().into_iter().try_for_each(|axis| from.sparse(axis))?;
        self.deserialise_grabs(from)
    }

    fn deserialise_grabs(&mut self, from: &mut StateReader) -> ReadResult {
        let mut pulls = Vec::new();
        for _ in 0..from.length(59)? {
            pulls.push(GrabSpring::deserialise(from, self.node_count())?);
        }
        let same = pulls.len() == self.grabs.len() && pulls.iter().zip(&self.grabs).all(|(a, b)| a.is_same_grab(b));
        if same {
            let targets = pulls.iter().enumerate();
            return targets.into_iter().try_for_each(|(i, p)| self.pull(i, p.target).map_err(|_| CorruptState));
        }
        while self.release_grab(0) {}
        for pull in pulls {
            self.grabs.push(pull);
            self.add_pull();
        }
        Ok(())
    }

    /// Serialise the state that a step takes from earlier steps, without contact.
    pub(crate) fn serialise_state(&self, to: &mut StateWriter, clearance: impl FnOnce(&mut StateWriter)) {
        self.pins.serialise(to);
        serialise_status(&self.status, to);
        to.byte(self.interpenetration as u8);
        to.numbers(&[self.rest_time, self.drag.pressure]);
        let c = &self.counters;
        [c.accepted, c.rejected, c.evaluations, c.guarded, c.contacts].into_iter().for_each(|n| to.count(n));
        to.vectors(&self.x);
        to.vectors(&self.v);
        if self.rest_time > 0.0 {
            to.vector_list(&self.rest_positions);
        }
        if let Some(tears) = &self.fracture {
            to.flags(tears.cells());
            tears.serialise(to);
        }
        to.flag(self.heat.is_some());
        self.heat.iter().for_each(|heat| heat.serialise(to));
        if self.is_changed() {
            self.serialise_changes(to);
        }
        self.recovery.iter().for_each(|guard| guard.state.serialise(to));
        self.serialise_history(to);
        to.flags(&self.work.touching);
        to.flag(self.work.stage.has_diverged);
        clearance(to);
        to.flag(self.work.adhesion.is_some());
        self.work.adhesion.iter().for_each(|stuck| stuck.serialise(to));
        to.flag(self.buckle_detector.is_some());
        self.buckle_detector.iter().for_each(|watch| watch.serialise(to));
    }

    /// Deserialise the state. Elements that were unchanged in the snapshot must be unchanged in
    /// this sheet.
    pub(crate) fn deserialise_state(
        &mut self,
        from: &mut StateReader,
        clearance: impl FnOnce(&mut StateReader, usize) -> ReadResult,
    ) -> ReadResult {
        let masses = self.node_count();
        deserialise_pins(self, from)?;
        let status = deserialise_status(from)?;
        let crossing = deserialise_interpenetration(from)?;
        (self.rest_time, self.drag.pressure) = (from.number()?, from.number()?);
        let c = &mut self.counters;
        let counts = [&mut c.accepted, &mut c.rejected, &mut c.evaluations, &mut c.guarded, &mut c.contacts];
        counts.into_iter().try_for_each(|n| from.count().map(|count| *n = count))?;
        let quiet = self.rest_time;
        from.vectors(&mut self.x)?;
        from.vectors(&mut self.v)?;
        if quiet > 0.0 {
            from.vector_list(&mut self.rest_positions, masses)?;
        }
        self.deserialise_fracture(from)?;
        self.deserialise_heat(from)?;
        if self.is_changed() {
            self.deserialise_changes(from)?;
        }
        if self.recovery.is_some() {
            let state = RecoveryState::deserialise(from)?;
            self.restore_recovery_state(Some(state));
        }
        self.deserialise_history(from)?;
        deserialise_touching(self, from)?;
        self.work.stage.has_diverged = from.flag()?;
        clearance(from, masses)?;
        self.displaced = false;
        self.work.adhesion =
            if from.flag()? { Some(Box::new(AdhesionState::deserialise(from, masses)?)) } else { None };
        deserialise_buckle_detector(self, from)?;
        // Deserialising the other state may have woken the sheet.
        (self.status, self.interpenetration, self.rest_time) = (status, crossing, quiet);
        Ok(())
    }

    /// Fix exactly the nodes that are pinned or detached.
    fn fix_pinned_nodes(&mut self) {
        let mut held = vec![false; self.node_count()];
        self.pins.masses().for_each(|m| held[m as usize] = true);
        for (i, held) in held.into_iter().enumerate() {
            self.inverse_mass[i] = if held || self.is_detached(i) { 0.0 } else { 1.0 / self.mass[i] };
        }
        self.invalidate_system();
    }

    fn deserialise_fracture(&mut self, from: &mut StateReader) -> ReadResult {
        if self.fracture.is_none() {
            return Ok(());
        }
        let mut cells = Vec::new();
        from.flags(&mut cells)?;
        if self.open_cells().is_none_or(|own| own.len() != cells.len()) {
            return Err(CorruptState);
        }
        self.set_open(&cells);
        self.fracture.as_mut().map_or(Ok(()), |tears| tears.deserialise(from))
    }

    fn deserialise_heat(&mut self, from: &mut StateReader) -> ReadResult {
        if !from.flag()? {
            return if self.heat.is_none() { Ok(()) } else { Err(CorruptState) };
        }
        self.start_temperatures(crate::units::temperature::REFERENCE);
        let Some(mut heat) = self.heat.take() else { return Err(CorruptState) };
        let taken = heat.deserialise(from, self);
        self.heat = Some(heat);
        taken
    }

    fn own_elements(&self) -> &[Box<dyn Element>] {
        &self.elements[..self.elements.len() - self.grabs.len()]
    }

    fn serialise_changes(&self, to: &mut StateWriter) {
        for list in [&self.springs.stiffness, &self.springs.rest, &self.springs.damping] {
            to.numbers(list);
        }
        self.own_elements().iter().for_each(|e| e.serialise_changes(to));
        self.inelastic.iter().for_each(|flow| flow.serialise(to));
    }

    fn deserialise_changes(&mut self, from: &mut StateReader) -> ReadResult {
        let count = self.springs.len();
        let mut lists = [(); 3].map(|()| vec![0.0; count]);
        lists.iter_mut().try_for_each(|list| from.numbers(list))?;
        let [stiffness, rest, damping] = lists;
        for i in 0..count {
            self.springs.set_law(i, stiffness[i], damping[i]);
            self.springs.set_rest(i, rest[i]);
        }
        self.spring_parameters.has_dashpots = self.springs.is_damped();
        let own = self.elements.len() - self.grabs.len();
        self.elements[..own].iter_mut().try_for_each(|e| e.deserialise_changes(from))?;
        if let Some(flow) = &mut self.inelastic {
            flow.deserialise(from)?;
        }
        if let Some(system) = &mut self.system {
            system.refresh(&self.springs);
        }
        Ok(())
    }

    /// Serialise the history of an implicit integrator; empty before its first step and after a
    /// restart.
    fn serialise_history(&self, to: &mut StateWriter) {
        self.engine.serialise(to);
        let begun = self.last_field.zip(self.system.as_ref());
        to.flag(begun.is_some());
        if let Some((field, system)) = begun {
            to.vector(field.gravity);
            to.numbers(&[field.air, field.air_density]);
            to.vector(field.wind);
            system.springs.serialise_history(to);
            self.own_elements().iter().for_each(|e| e.serialise_history(to));
        }
    }

    fn deserialise_history(&mut self, from: &mut StateReader) -> ReadResult {
        self.engine.deserialise(from, self.node_count())?;
        self.last_field = None;
        if !from.flag()? {
            return Ok(());
        }
        let (gravity, air, air_density) = (from.vector()?, from.number()?, from.number()?);
        let field = Field { gravity, air, air_density, wind: from.vector()? };
        let mut system = self.system.take().unwrap_or_else(|| Box::new(ImplicitSystem::new(self)));
        system.forget_constant();
        let taken = system.springs.deserialise_history(from);
        self.system = Some(system);
        taken?;
        let own = self.elements.len() - self.grabs.len();
        self.elements[..own].iter_mut().try_for_each(|e| e.deserialise_history(from))?;
        self.last_field = Some(field);
        Ok(())
    }
}

fn serialise_material(material: &Material, to: &mut StateWriter) {
    to.text(&material.name);
    // `Material` omits an empty name when it is written, so the name is written separately.
    let named = Material { name: "-".to_owned(), ..material.clone() };
    let bytes = postcard::to_extend(&named, Vec::new()).unwrap_or_default();
    to.blob(&bytes);
}

fn deserialise_material(from: &mut StateReader) -> ReadResult<Material> {
    let name = from.text()?.to_owned();
    let mut material: Material = postcard::from_bytes(from.blob()?).map_err(|_| CorruptState)?;
    material.name = name;
    validate::material("material", &material).map_err(|_| CorruptState)?;
    Ok(material)
}

fn serialise_status(status: &Status, to: &mut StateWriter) {
    match status {
        Status::Awake => to.byte(0),
        Status::Asleep => to.byte(1),
        Status::Unstable { time, mass, place, speed } => {
            to.byte(2);
            to.numbers(&[*time, *speed]);
            to.count(u64::from(*mass));
            to.vector(*place);
        }
        Status::Frozen { time } => {
            to.byte(3);
            to.number(*time);
        }
    }
}

fn deserialise_pins(sheet: &mut Sheet, from: &mut StateReader) -> ReadResult {
    let mut pins = std::mem::take(&mut sheet.pins);
    let others = pins.deserialise(from, sheet.node_count());
    sheet.pins = pins;
    if others? {
        sheet.fix_pinned_nodes();
    }
    Ok(())
}

/// Deserialise which nodes touch something; an empty list leaves them as they are.
fn deserialise_touching(sheet: &mut Sheet, from: &mut StateReader) -> ReadResult {
    let mut touching = Vec::new();
    from.flags(&mut touching)?;
    if touching.len() == sheet.node_count() {
        sheet.resize_workspace();
        sheet.work.touching = touching;
    } else if !touching.is_empty() {
        return Err(CorruptState);
    }
    Ok(())
}

fn deserialise_buckle_detector(sheet: &mut Sheet, from: &mut StateReader) -> ReadResult {
    if from.flag()? {
        let mut watch = crate::sheet::buckling::BuckleDetector::default();
        watch.deserialise(from, sheet.node_count(), sheet.opening_revision())?;
        sheet.buckle_detector.iter_mut().for_each(|own| **own = std::mem::take(&mut watch));
    }
    Ok(())
}

fn deserialise_interpenetration(from: &mut StateReader) -> ReadResult<Interpenetration> {
    Ok(match from.byte()? {
        0 => Interpenetration::Unknown,
        1 => Interpenetration::None,
        2 => Interpenetration::Detected,
        3 => Interpenetration::Reported,
        _ => return Err(CorruptState),
    })
}

fn deserialise_status(from: &mut StateReader) -> ReadResult<Status> {
    Ok(match from.byte()? {
        0 => Status::Awake,
        1 => Status::Asleep,
        2 => {
            let (time, speed, mass) = (from.number()?, from.number()?, from.count_u32()?);
            let place: DVec3 = from.vector()?;
            Status::Unstable { time, mass, place, speed }
        }
        3 => Status::Frozen { time: from.number()? },
        _ => return Err(CorruptState),
    })
}
