//! Sheets that are out of the simulation for a time, with their state.

use crate::contact::SheetContact;
use crate::islands::contact_log::ContactLog;
use crate::scene::SheetSpec;
use crate::sheet::attached_body::AttachedTo;
use crate::sheet::{Sheet, attachment, stage};
use crate::world::World;
use crate::world::ids::{SheetId, Slot};

/// Sheet that is out of the simulation.
pub(crate) struct SuspendedSheet {
    pub(super) slot: Slot,
    pub(super) sheet: Sheet,
    pub(super) spec: SheetSpec,
    /// Time of the suspension, s.
    since: f64,
}

impl World {
    /// Take the sheet `id` out of the simulation until [`World::resume_sheet`]: it is not stepped,
    /// nothing meets it, and it is not among [`World::sheets`]. Its id and its name remain its own.
    /// Attachments to bodies of the caller's rigid world end. Snapshots do not contain it. Returns
    /// `false` when it was removed or is suspended.
    pub fn suspend_sheet(&mut self, id: SheetId) -> bool {
        let Some(index) = self.sheet_ids.position(id.0) else { return false };
        let (spec, time) = (self.scene.sheets[index].clone(), self.time);
        self.wake_around(index);
        self.sheet_ids.suspend(index);
        let mut sheet = self.take_sheet_at(index);
        attachment::detach_lent(&mut sheet, |_| true);
        self.suspended.push(SuspendedSheet { slot: id.0, sheet, spec, since: time });
        true
    }

    /// Put a suspended sheet back where it was, with its shape, velocities and temperatures. It is
    /// the last of the sheets then. Its paths and the ends of its pins are later by the time it was
    /// out; attachments hold its nodes at their place relative to the present pose of the body.
    /// Where it lies inside a body or crosses another sheet, contact treats it as one that began
    /// there. Returns `false` when it is not suspended.
    pub fn resume_sheet(&mut self, id: SheetId) -> bool {
        let Some(index) = self.suspended.iter().position(|suspended| suspended.slot == id.0) else { return false };
        let SuspendedSheet { mut sheet, spec, since, .. } = self.suspended.remove(index);
        sheet.pins.delay(self.time - since);
        let rigid = self.rigid.as_deref();
        attachment::renew_attachments(&mut sheet, |owner| match owner {
            AttachedTo::Own(body) => rigid.and_then(|rigid| rigid.state(body)).copied(),
            AttachedTo::Lent(_) => None,
        });
        sheet.state.touching.fill(false);
        stage::restart_engine(&mut sheet);
        sheet.invalidate_interpenetration();
        sheet.wake();
        self.lod.iter_mut().for_each(|lod| lod.add(sheet.state.counters.evaluations));
        self.scene.sheets.push(spec);
        self.sheets.push(sheet);
        self.sheet_contacts.push(SheetContact::default());
        self.contact_logs.push(ContactLog::default());
        self.structure.add_sheet(&self.scene);
        self.sheet_ids.resume(id.0);
        self.heat.iter_mut().for_each(|heat| heat.discard_views());
        self.wake_around(self.sheets.len() - 1);
        true
    }

    /// Remove a suspended sheet. Returns `false` when it is not suspended.
    pub(super) fn remove_suspended(&mut self, id: SheetId) -> bool {
        let Some(index) = self.suspended.iter().position(|suspended| suspended.slot == id.0) else { return false };
        self.suspended.remove(index);
        self.sheet_ids.release(id.0);
        true
    }

    /// Ids of the suspended sheets.
    pub(super) fn suspended_ids(&self) -> Vec<SheetId> {
        self.suspended.iter().map(|suspended| SheetId(suspended.slot)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;

    /// A led sheet, and one that is attached to a body.
    fn world() -> (World, [SheetId; 2]) {
        let scene = Scene::parse(
            r#"(bodies: [(name: "post", shape: Box((0.02, 0.02, 0.02)), placement: (position: (1, 0, 0)))],
                sheets: [(name: "led", structure: "shell", grid: (5, 1, 5), size: (0.1, 0.1), material: "pet",
                    pins: [(region: Left, path: [(time: 0, offset: (0, 0, 0)), (time: 1, offset: (0, 1, 0))])]),
                    (name: "glued", structure: "shell", grid: (5, 1, 5), size: (0.1, 0.1), material: "pet",
                    placement: (position: (1, 0.2, 0)), pins: [(region: Left, body: "post")])])"#,
        );
        let world = World::new(&scene.expect("valid")).expect("valid");
        let ids = ["led", "glued"].map(|name| world.sheet_id(name).expect("there"));
        (world, ids)
    }

    #[test]
    fn a_resumed_sheet_goes_on_along_its_path() {
        let (mut world, [led, glued]) = world();
        world.advance(0.2);
        let place = |world: &World| world.get_sheet(led).expect("there").state.x.get(0);
        let before = place(&world);
        assert!(world.suspend_sheet(led) && !world.suspend_sheet(led));
        assert!(world.get_sheet(led).is_none() && world.sheets().len() == 1);
        world.advance(0.5);
        assert!(world.resume_sheet(led) && !world.resume_sheet(led));
        assert_eq!((place(&world), world.sheet_id("led"), world.sheet_id("glued")), (before, Some(led), Some(glued)));
        world.advance(0.1);
        assert!((place(&world).y - before.y - 0.1).abs() < 1e-9, "{} {before}", place(&world));
    }

    #[test]
    fn a_suspended_sheet_is_reset_removed_and_detached_from_its_body() {
        let (mut world, [led, glued]) = world();
        let start = world.get_sheet(glued).expect("there").state.x.clone();
        world.advance(0.1);
        assert!(world.suspend_sheet(glued));
        world.reset().expect("valid");
        assert!(world.get_sheet(glued).is_none() && world.resume_sheet(glued));
        assert_eq!(world.get_sheet(glued).expect("there").state.x, start);
        assert!(world.suspend_sheet(glued) && world.suspend_sheet(led));
        assert!(world.remove_body(world.body_id("post").expect("there")));
        assert!(world.resume_sheet(glued) && world.remove_sheet(led) && !world.resume_sheet(led));
        world.advance(0.5);
        let fallen = world.get_sheet(glued).expect("there");
        assert!(fallen.state.x.iter().all(|x| x.y < 0.0), "nothing holds it");
    }
}
