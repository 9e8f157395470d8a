//! Generational ids of the sheets, bodies and heaters of a world.
//!
//! An id belongs to the world that gave it and names one object as long as that object exists,
//! whatever is added or removed beside it. The id of a removed object names nothing from then on,
//! although its slot is used again: the slot's generation has changed.

/// Slot of an object and the generation of that slot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct Slot {
    index: u32,
    generation: u32,
}

/// Id of a sheet of a [`World`](crate::World).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SheetId(pub(crate) Slot);

/// Id of a rigid body of a [`World`](crate::World).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct BodyId(pub(crate) Slot);

/// Id of a heater of a [`World`](crate::World).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct HeaterId(pub(crate) Slot);

/// Generation of a slot, and position of its object in the list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct SlotEntry {
    generation: u32,
    position: Option<usize>,
}

/// Slots of the objects of one list, which shifts when an object is removed.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct IdTable {
    slots: Vec<SlotEntry>,
    /// Slot index of each object, in the order of the list.
    order: Vec<u32>,
    /// Slots without object; the last one is used next.
    free: Vec<u32>,
}

impl IdTable {
    /// Table of a list with `count` objects.
    pub(crate) fn new(count: usize) -> Self {
        let mut table = Self::default();
        for _ in 0..count {
            table.push();
        }
        table
    }

    /// Slot of an object appended to the list.
    pub(crate) fn push(&mut self) -> Slot {
        let index = self.free.pop().unwrap_or(self.slots.len() as u32);
        if index as usize == self.slots.len() {
            self.slots.push(SlotEntry { generation: 0, position: None });
        }
        let entry = &mut self.slots[index as usize];
        entry.position = Some(self.order.len());
        self.order.push(index);
        Slot { index, generation: entry.generation }
    }

    /// Remove the object at `position` of the list.
    pub(crate) fn remove(&mut self, position: usize) {
        let index = self.order.remove(position);
        let entry = &mut self.slots[index as usize];
        *entry = SlotEntry { generation: entry.generation + 1, position: None };
        self.free.push(index);
        self.update_positions();
    }

    /// Take the object at `position` out of the list; its slot remains its own.
    pub(crate) fn suspend(&mut self, position: usize) {
        let index = self.order.remove(position);
        self.slots[index as usize].position = None;
        self.update_positions();
    }

    /// Append a suspended object to the list.
    pub(crate) fn resume(&mut self, slot: Slot) {
        self.slots[slot.index as usize].position = Some(self.order.len());
        self.order.push(slot.index);
    }

    /// Release the slot of a suspended object.
    pub(crate) fn release(&mut self, slot: Slot) {
        self.slots[slot.index as usize] = SlotEntry { generation: slot.generation + 1, position: None };
        self.free.push(slot.index);
    }

    /// Whether the object exists, in the list or suspended.
    pub(crate) fn exists(&self, slot: Slot) -> bool {
        self.slots.get(slot.index as usize).is_some_and(|entry| entry.generation == slot.generation)
    }

    /// Whether the object exists and is suspended.
    pub(crate) fn is_suspended(&self, slot: Slot) -> bool {
        self.exists(slot) && self.position(slot).is_none()
    }

    /// Replace the list: `former` are the former positions of its objects, `None` for a new one.
    /// Objects without a place in the new list are removed.
    pub(crate) fn replace(&mut self, former: &[Option<usize>]) {
        for position in (0..self.order.len()).rev().filter(|position| !former.contains(&Some(*position))) {
            let index = self.order[position];
            let entry = &mut self.slots[index as usize];
            *entry = SlotEntry { generation: entry.generation + 1, position: None };
            self.free.push(index);
        }
        let order = std::mem::take(&mut self.order);
        for position in former {
            match position {
                Some(position) => self.order.push(order[*position]),
                None => _ = self.push(),
            }
        }
        self.update_positions();
    }

    fn update_positions(&mut self) {
        for (position, index) in self.order.iter().enumerate() {
            self.slots[*index as usize].position = Some(position);
        }
    }

    /// Position in the list; `None` for an object that was removed.
    pub(crate) fn position(&self, slot: Slot) -> Option<usize> {
        self.slots.get(slot.index as usize).filter(|entry| entry.generation == slot.generation)?.position
    }

    /// Slot of the object at `position` of the list.
    pub(crate) fn at(&self, position: usize) -> Option<Slot> {
        let index = *self.order.get(position)?;
        Some(Slot { index, generation: self.slots[index as usize].generation })
    }

    /// Slots of all objects, in the order of the list.
    pub(crate) fn iter(&self) -> impl ExactSizeIterator<Item = Slot> + '_ {
        self.order.iter().map(|index| Slot { index: *index, generation: self.slots[*index as usize].generation })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slot_keeps_its_object_and_a_stale_slot_names_nothing() {
        let mut table = IdTable::new(3);
        let ids: Vec<Slot> = table.iter().collect();
        table.remove(1);
        assert_eq!(ids.iter().map(|id| table.position(*id)).collect::<Vec<_>>(), [Some(0), None, Some(1)]);
        let reused = table.push();
        assert_eq!(reused.index, ids[1].index);
        assert_ne!(reused, ids[1]);
        assert_eq!((table.position(ids[1]), table.position(reused)), (None, Some(2)));
        table.replace(&[Some(2), None, Some(0)]);
        let positions = [reused, ids[0], ids[2]].map(|slot| table.position(slot));
        assert_eq!(positions, [Some(0), Some(2), None]);
        assert_eq!((table.at(0), table.at(2), table.at(3)), (Some(reused), Some(ids[0]), None));
        table.suspend(0);
        assert!(table.position(reused).is_none() && table.exists(reused) && table.push() != reused);
        table.resume(reused);
        assert_eq!((table.position(ids[0]), table.position(reused)), (Some(1), Some(3)));
        table.suspend(3);
        table.release(reused);
        assert!(!table.exists(reused) && table.push().index == reused.index);
    }
}
