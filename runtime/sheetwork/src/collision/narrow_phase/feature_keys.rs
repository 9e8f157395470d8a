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
