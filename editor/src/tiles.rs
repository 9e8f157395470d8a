//! Division of the view among compared worlds: side by side, or in a grid where that gives larger
//! tiles.

use bevy_egui::egui::{Rect, pos2, vec2};

/// Width of the gap between tiles, points.
const GAP: f32 = 2.0;

/// Tiles of `rect` for `count` worlds, in rows from the upper left; the number of columns gives the
/// largest square in each tile.
pub fn tiles(rect: Rect, count: usize) -> Vec<Rect> {
    let square = |columns: usize| {
        let rows = count.div_ceil(columns);
        (rect.width() / columns as f32).min(rect.height() / rows as f32)
    };
    let empty = |columns: usize| columns * count.div_ceil(columns) - count;
    let better = |a: &usize, b: &usize| square(*a).total_cmp(&square(*b)).then(empty(*b).cmp(&empty(*a)));
    let columns = (1..=count.max(1)).max_by(better).unwrap_or(1);
    let rows = count.div_ceil(columns).max(1);
    let size = vec2(rect.width() / columns as f32, rect.height() / rows as f32);
    let tile = |i: usize| {
        let (column, row) = ((i % columns) as f32, (i / columns) as f32);
        let low = pos2(rect.left() + column * size.x, rect.top() + row * size.y);
        let gap = |at: usize, of: usize| if at + 1 < of { GAP } else { 0.0 };
        Rect::from_min_size(low, size - vec2(gap(i % columns, columns), gap(i / columns, rows)))
    };
    (0..count.max(1)).map(tile).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_has_all_and_more_share_without_overlap() {
        let rect = Rect::from_min_size(pos2(10.0, 20.0), vec2(800.0, 500.0));
        assert_eq!(tiles(rect, 1), [rect]);
        for count in 2..=4 {
            let all = tiles(rect, count);
            assert_eq!(all.len(), count);
            for (i, a) in all.iter().enumerate() {
                assert!(rect.expand(0.01).contains_rect(*a) && a.width() > 180.0 && a.height() > 180.0);
                assert!(all[i + 1..].iter().all(|b| !a.shrink(0.1).intersects(*b)));
            }
        }
        assert!(tiles(rect, 2)[0].height() == 500.0, "side by side in a wide view");
        let high = Rect::from_min_size(pos2(0.0, 0.0), vec2(300.0, 700.0));
        assert!(tiles(high, 2)[0].width() == 300.0, "one above the other in a high one");
        assert!(tiles(rect, 4)[3].left() > 400.0 && tiles(rect, 4)[3].top() > 260.0, "two by two");
    }
}
