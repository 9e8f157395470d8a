//! Keys of features: the kind of feature, its sheet or body, and its index there.

use crate::collision::constraint::ContactKey;

/// Kind of a feature.
#[derive(Clone, Copy)]
pub(crate) enum FeatureKind {
    Node = 1,
    SheetEdge,
    Triangle,
    Face,
    BodyEdge,
    Corner,
    Ball,
}

/// Key of feature `index` of the sheet or body `id`.
pub(crate) fn feature_key(kind: FeatureKind, id: u32, index: u32) -> u64 {
    (kind as u64) << 56 | u64::from(id & 0x00ff_ffff) << 32 | u64::from(index)
}

/// First part of the key of an attachment; a feature has a lower one.
pub(crate) const ATTACHMENT_KEY: u64 = u64::MAX;

/// Key of the attachment of node `node` of the sheet `id` to the body `body`.
pub(crate) fn attachment_key(id: u32, node: u32, body: usize) -> ContactKey {
    [ATTACHMENT_KEY, (u64::from(id) << 32 | u64::from(node)) ^ (body as u64) << 48]
}

/// Key of the contact of node `node` of the sheet `id` with place `place` of the layer next to it;
/// triangles have lower indices than these places.
pub(crate) fn layer_key(id: u32, node: u32, place: u32) -> ContactKey {
    [feature_key(FeatureKind::Node, id, node), feature_key(FeatureKind::Triangle, id, 1 << 31 | place)]
}

/// `key` after the removal of the sheet `id`, by which higher identifiers are lower by one; `None`
/// for a contact of that sheet. Keys keep their order.
pub(crate) fn without_sheet(key: &ContactKey, id: u32) -> Option<ContactKey> {
    let moved = |part: u64, mask: u64, is_sheet: bool| {
        let own = (part >> 32 & mask) as u32;
        if is_sheet && own == id { None } else { Some(part - (u64::from(is_sheet && own > id) << 32)) }
    };
    if key[0] == ATTACHMENT_KEY {
        return Some([key[0], moved(key[1], 0xffff, true)?]);
    }
    let of = |part: u64| moved(part, 0x00ff_ffff, part >> 56 <= FeatureKind::Triangle as u64);
    Some([of(key[0])?, of(key[1])?])
}

/// Number of the sheet or body that owns a feature, equal for all its features.
pub(crate) fn feature_owner(name: u64) -> u64 {
    let is_sheet = name >> 56 <= FeatureKind::Triangle as u64;
    (name >> 32 & 0x00ff_ffff) << 1 | u64::from(is_sheet)
}

/// Whether a constraint with this key joins a node to the surface of a body.
pub(crate) fn is_node_surface_contact(key: &ContactKey) -> bool {
    let [of, on] = key.map(|name| name >> 56);
    of == FeatureKind::Node as u64 && (on == FeatureKind::Face as u64 || on == FeatureKind::Ball as u64)
}

/// Whether a constraint with this key joins a feature to a ball.
pub(crate) fn is_ball_contact(key: &ContactKey) -> bool {
    key[1] >> 56 == FeatureKind::Ball as u64
}
