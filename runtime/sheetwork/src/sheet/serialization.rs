//! Serialisation of a sheet for snapshots: parameters that can change during a run, and state that
//! a step takes from earlier steps.
//!
//! Topology, node masses and rest shape follow from the scene and are not serialised, nor is the
//! workspace of a step. Elements serialise their rates and stresses while an implicit integrator
//! runs, and their law where temperature, creep, plasticity or fracture have changed it.

use glam::DVec3;

use crate::elements::Element;
use crate::elements::grab_spring::Pull;
use crate::scene::{Material, WhenUnstable, validate};
use crate::serialize::{Cut, Keeper, Taken, Taker};
use crate::sheet::bonds::Stuck;
use crate::sheet::{Crossing, Field, GuardState, Sheet, Status, System};

impl Sheet {
    /// Serialise the layout that a snapshot must match.
    pub(crate) fn keep_make(&self, to: &mut Keeper) {
        to.text(&self.name);
        let own = self.elements.len() - self.pulls.len();
        for count in [self.masses(), self.springs.len(), own, self.layers.len()] {
            to.count(count as u64);
        }
        to.count(self.open_cells().map_or(0, <[bool]>::len) as u64);
        to.flag(self.flow.is_some());
    }

    /// Whether steps have changed the law of its elements or its open cells.
    pub(crate) fn is_changed(&self) -> bool {
        self.heat.is_some() || self.flow.is_some() || self.open_count() > 0
    }

    /// Serialise the parameters that can change during a run.
    pub(crate) fn keep_settings(&self, to: &mut Keeper) {
        keep_material(&self.material, to);
        to.numbers(&[self.friction, self.restitution, self.damping, self.damping_ratio]);
        to.optional(self.flexion_angle_limit());
        self.drag.keep_settings(to);
        to.optional(self.flow.as_ref().map(|f| f.celsius()));
        to.text(self.own_engine().name());
        self.when_unstable().keep(to);
        to.number(self.longest);
        self.applied.axes().into_iter().for_each(|axis| to.sparse(axis));
        to.count(self.pulls.len() as u64);
        self.pulls.iter().for_each(|pull| pull.keep(to));
    }

    /// Deserialise the parameters; `tolerance` is that of an adaptive integrator, m.
    pub(crate) fn take_settings(&mut self, from: &mut Taker, tolerance: f64) -> Taken {
        let material = take_material(from)?;
        (self.friction, self.restitution) = (from.number()?, from.number()?);
        let (damping, ratio) = (from.number()?, from.number()?);
        if (damping, ratio) != (self.damping, self.damping_ratio) {
            (self.damping, self.damping_ratio) = (damping, ratio);
            self.refresh();
        }
        if material != self.material {
            self.set_material(material).map_err(|_| Cut)?;
        }
        let limit = from.optional()?;
        if limit != self.flexion_angle_limit() {
            self.set_flexion_limit(limit).map_err(|_| Cut)?;
        }
        self.drag.take_settings(from)?;
        let celsius = from.optional()?;
        if let Some((flow, celsius)) = self.flow.as_mut().zip(celsius) {
            flow.set_celsius(celsius);
        }
        let engine = from.text()?.parse().map_err(|_| Cut)?;
        if engine != self.own_engine() {
            self.set_engine(engine, tolerance);
        }
        self.engine.set_tolerance(tolerance);
        let policy = WhenUnstable::taken(from)?;
        if policy != self.when_unstable() {
            self.watch_over(policy, tolerance);
        }
        self.guard.iter_mut().for_each(|guard| guard.tolerance = tolerance);
        self.longest = from.number()?;
        // A shorter step than 1e-9 s would need an unbounded number of substeps.
        if self.longest.is_nan() || self.longest < 1e-9 {
            return Err(Cut);
        }
        self.applied.axes_mut().into_iter().try_for_each(|axis| from.sparse(axis))?;
        self.take_pulls(from)
    }

    fn take_pulls(&mut self, from: &mut Taker) -> Taken {
        let mut pulls = Vec::new();
        for _ in 0..from.length(59)? {
            pulls.push(Pull::taken(from, self.masses())?);
        }
        let same = pulls.len() == self.pulls.len() && pulls.iter().zip(&self.pulls).all(|(a, b)| a.is_of(b));
        if same {
            let targets = pulls.iter().enumerate();
            return targets.into_iter().try_for_each(|(i, p)| self.pull(i, p.target).map_err(|_| Cut));
        }
        while self.let_go(0) {}
        for pull in pulls {
            self.pulls.push(pull);
            self.add_pull();
        }
        Ok(())
    }

    /// Serialise the state that a step takes from earlier steps, without contact.
    pub(crate) fn keep_state(&self, to: &mut Keeper, clearance: impl FnOnce(&mut Keeper)) {
        self.pins.keep(to);
        keep_status(&self.status, to);
        to.byte(self.crossing as u8);
        to.numbers(&[self.quiet, self.drag.pressure]);
        let c = &self.counters;
        [c.accepted, c.rejected, c.evaluations, c.guarded, c.contacts].into_iter().for_each(|n| to.count(n));
        to.vectors(&self.x);
        to.vectors(&self.v);
        if self.quiet > 0.0 {
            to.vector_list(&self.still_at);
        }
        if let Some(tears) = &self.tears {
            to.flags(tears.cells());
            tears.keep(to);
        }
        to.flag(self.heat.is_some());
        self.heat.iter().for_each(|heat| heat.keep(to));
        if self.is_changed() {
            self.keep_changes(to);
        }
        self.guard.iter().for_each(|guard| guard.state.keep(to));
        self.keep_history(to);
        to.flags(&self.work.touching);
        to.flag(self.work.stage.astray);
        clearance(to);
        to.flag(self.work.stuck.is_some());
        self.work.stuck.iter().for_each(|stuck| stuck.keep(to));
        to.flag(self.watch.is_some());
        self.watch.iter().for_each(|watch| watch.keep(to));
    }

    /// Deserialise the state. Elements that were unchanged in the snapshot must be unchanged in
    /// this sheet.
    pub(crate) fn take_state(&mut self, from: &mut Taker, clearance: impl FnOnce(&mut Taker, usize) -> Taken) -> Taken {
        let masses = self.masses();
        let mut pins = std::mem::take(&mut self.pins);
        let others = pins.take(from, masses);
        self.pins = pins;
        if others? {
            self.hold_pinned();
        }
        let status = take_status(from)?;
        let crossing = match from.byte()? {
            0 => Crossing::Unknown,
            1 => Crossing::No,
            2 => Crossing::Seen,
            3 => Crossing::Told,
            _ => return Err(Cut),
        };
        (self.quiet, self.drag.pressure) = (from.number()?, from.number()?);
        let c = &mut self.counters;
        let counts = [&mut c.accepted, &mut c.rejected, &mut c.evaluations, &mut c.guarded, &mut c.contacts];
        counts.into_iter().try_for_each(|n| from.count().map(|count| *n = count))?;
        let quiet = self.quiet;
        from.vectors(&mut self.x)?;
        from.vectors(&mut self.v)?;
        if quiet > 0.0 {
            from.vector_list(&mut self.still_at, masses)?;
        }
        self.take_openings_back(from)?;
        self.take_heat(from)?;
        if self.is_changed() {
            self.take_changes(from)?;
        }
        if self.guard.is_some() {
            let state = GuardState::taken(from)?;
            self.restore_guard(Some(state));
        }
        self.take_history(from)?;
        let mut touching = Vec::new();
        from.flags(&mut touching)?;
        if touching.len() == masses {
            self.size_work();
            self.work.touching = touching;
        } else if !touching.is_empty() {
            return Err(Cut);
        }
        self.work.stage.astray = from.flag()?;
        clearance(from, masses)?;
        self.displaced = false;
        self.work.stuck = if from.flag()? { Some(Box::new(Stuck::taken(from, masses)?)) } else { None };
        if from.flag()? {
            let mut watch = crate::sheet::buckling::Watch::default();
            watch.take(from, masses, self.opening_revision())?;
            self.watch.iter_mut().for_each(|own| **own = std::mem::take(&mut watch));
        }
        // Deserialising the other state may have woken the sheet.
        (self.status, self.crossing, self.quiet) = (status, crossing, quiet);
        Ok(())
    }

    /// Fix exactly the nodes that are pinned or detached.
    fn hold_pinned(&mut self) {
        let mut held = vec![false; self.masses()];
        self.pins.masses().for_each(|m| held[m as usize] = true);
        for (i, held) in held.into_iter().enumerate() {
            self.inverse_mass[i] = if held || self.is_gone(i) { 0.0 } else { 1.0 / self.mass[i] };
        }
        self.forget_system();
    }

    fn take_openings_back(&mut self, from: &mut Taker) -> Taken {
        if self.tears.is_none() {
            return Ok(());
        }
        let mut cells = Vec::new();
        from.flags(&mut cells)?;
        if self.open_cells().is_none_or(|own| own.len() != cells.len()) {
            return Err(Cut);
        }
        self.set_open(&cells);
        self.tears.as_mut().map_or(Ok(()), |tears| tears.take(from))
    }

    fn take_heat(&mut self, from: &mut Taker) -> Taken {
        if !from.flag()? {
            return if self.heat.is_none() { Ok(()) } else { Err(Cut) };
        }
        self.begin_heat(crate::units::temperature::REFERENCE);
        let Some(mut heat) = self.heat.take() else { return Err(Cut) };
        let taken = heat.take(from, self);
        self.heat = Some(heat);
        taken
    }

    fn own_elements(&self) -> &[Box<dyn Element>] {
        &self.elements[..self.elements.len() - self.pulls.len()]
    }

    fn keep_changes(&self, to: &mut Keeper) {
        for list in [&self.springs.stiffness, &self.springs.rest, &self.springs.damping] {
            to.numbers(list);
        }
        self.own_elements().iter().for_each(|e| e.keep_changes(to));
        self.flow.iter().for_each(|flow| flow.keep(to));
    }

    fn take_changes(&mut self, from: &mut Taker) -> Taken {
        let count = self.springs.len();
        let mut lists = [(); 3].map(|()| vec![0.0; count]);
        lists.iter_mut().try_for_each(|list| from.numbers(list))?;
        let [stiffness, rest, damping] = lists;
        for i in 0..count {
            self.springs.set_law(i, stiffness[i], damping[i]);
            self.springs.set_rest(i, rest[i]);
        }
        self.damped = self.springs.damped();
        let own = self.elements.len() - self.pulls.len();
        self.elements[..own].iter_mut().try_for_each(|e| e.take_changes(from))?;
        if let Some(flow) = &mut self.flow {
            flow.take(from)?;
        }
        if let Some(system) = &mut self.system {
            system.refresh(&self.springs);
        }
        Ok(())
    }

    /// Serialise the history of an implicit integrator; empty before its first step and after a
    /// restart.
    fn keep_history(&self, to: &mut Keeper) {
        self.engine.keep(to);
        let begun = self.field_before.zip(self.system.as_ref());
        to.flag(begun.is_some());
        if let Some((field, system)) = begun {
            to.vector(field.gravity);
            to.numbers(&[field.air, field.air_density]);
            to.vector(field.wind);
            system.springs.keep_history(to);
            self.own_elements().iter().for_each(|e| e.keep_history(to));
        }
    }

    fn take_history(&mut self, from: &mut Taker) -> Taken {
        self.engine.take(from, self.masses())?;
        self.field_before = None;
        if !from.flag()? {
            return Ok(());
        }
        let (gravity, air, air_density) = (from.vector()?, from.number()?, from.number()?);
        let field = Field { gravity, air, air_density, wind: from.vector()? };
        let mut system = self.system.take().unwrap_or_else(|| Box::new(System::new(self)));
        system.forget_constant();
        let taken = system.springs.take_history(from);
        self.system = Some(system);
        taken?;
        let own = self.elements.len() - self.pulls.len();
        self.elements[..own].iter_mut().try_for_each(|e| e.take_history(from))?;
        self.field_before = Some(field);
        Ok(())
    }
}

fn keep_material(material: &Material, to: &mut Keeper) {
    to.text(&material.name);
    // `Material` omits an empty name when it is written, so the name is written separately.
    let named = Material { name: "-".to_owned(), ..material.clone() };
    let bytes = postcard::to_extend(&named, Vec::new()).unwrap_or_default();
    to.blob(&bytes);
}

fn take_material(from: &mut Taker) -> Taken<Material> {
    let name = from.text()?.to_owned();
    let mut material: Material = postcard::from_bytes(from.blob()?).map_err(|_| Cut)?;
    material.name = name;
    validate::material("material", &material).map_err(|_| Cut)?;
    Ok(material)
}

fn keep_status(status: &Status, to: &mut Keeper) {
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

fn take_status(from: &mut Taker) -> Taken<Status> {
    Ok(match from.byte()? {
        0 => Status::Awake,
        1 => Status::Asleep,
        2 => {
            let (time, speed, mass) = (from.number()?, from.number()?, from.small()?);
            let place: DVec3 = from.vector()?;
            Status::Unstable { time, mass, place, speed }
        }
        3 => Status::Frozen { time: from.number()? },
        _ => return Err(Cut),
    })
}
