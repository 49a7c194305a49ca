//! Lines along which one surface stands on another, goes through it, or hovers close above it.
//!
//! An element that runs under a partition carries light through the wall, and no estimate of noise sees it:
//! elements are cut along these lines. A lamp under a ceiling and a mirror on a wall part dark from light as well.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::polygon::clip_line;
use super::surfaces::{Surface, TOUCH};

/// Height up to which an edge along a surface shades it like one that lies on it: in units of the scene's size, and in
/// widths of what hovers.
const HOVER: f64 = 0.02;
const HOVER_WIDTHS: f64 = 0.1;

/// For every surface, the others whose bounding boxes touch its own, in ascending order.
pub(super) fn neighbours(list: &[Surface]) -> Vec<Vec<u32>> {
    within(list, (0..u32::try_from(list.len()).unwrap_or(u32::MAX)).collect(), TOUCH)
}

/// For every surface wide enough to hover, the others of that kind whose bounding boxes come close to its own.
fn hovering(list: &[Surface]) -> Vec<Vec<u32>> {
    let wide = |i: &u32| list[*i as usize].extent.max_element() > 2.0 * HOVER;
    within(list, (0..u32::try_from(list.len()).unwrap_or(u32::MAX)).filter(wide).collect(), HOVER)
}

/// For every surface among `order`, the others whose bounding boxes, grown by `margin`, meet its own.
fn within(list: &[Surface], mut order: Vec<u32>, margin: f64) -> Vec<Vec<u32>> {
    let boxes: Vec<(DVec3, DVec3)> = list
        .iter()
        .map(|s| {
            let low = s.vertices.iter().copied().fold(DVec3::INFINITY, DVec3::min);
            let high = s.vertices.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
            (low - margin, high + margin)
        })
        .collect();
    order.par_sort_by(|a, b| boxes[*a as usize].0.x.total_cmp(&boxes[*b as usize].0.x));
    let after = |(rank, i): (usize, &u32)| -> Vec<u32> {
        let (low, high) = boxes[*i as usize];
        let meets = |j: &&u32| {
            let other = boxes[**j as usize];
            other.0.cmple(high).all() && low.cmple(other.1).all()
        };
        // Sorted by the low end: sweep and prune.
        order[rank + 1..].iter().take_while(|j| boxes[**j as usize].0.x <= high.x).filter(meets).copied().collect()
    };
    let pairs: Vec<Vec<u32>> = order.par_iter().enumerate().map(after).collect();
    let mut found = vec![Vec::new(); list.len()];
    for (i, others) in order.iter().zip(pairs) {
        for j in others {
            found[*i as usize].push(j);
            found[j as usize].push(*i);
        }
    }
    found.par_iter_mut().for_each(|f| f.sort_unstable());
    found
}

/// Fills [`Surface::cuts`]. Contacts come first, as a cell takes a few lines only.
pub(super) fn find_cuts(list: &mut [Surface], neighbours: &[Vec<u32>]) {
    let hovering = hovering(list);
    let cuts: Vec<Vec<[DVec2; 2]>> = list
        .par_iter()
        .zip(neighbours.par_iter().zip(&hovering))
        .map(|(s, (touching, hovering))| cuts_of(s, touching.iter().chain(hovering).map(|j| &list[*j as usize])))
        .collect();
    for (s, c) in list.iter_mut().zip(cuts) {
        s.cuts = c;
    }
}

fn cuts_of<'a>(surface: &Surface, others: impl Iterator<Item = &'a Surface>) -> Vec<[DVec2; 2]> {
    let mut cuts: Vec<[DVec2; 2]> = Vec::new();
    for other in others {
        for (a, b) in touching_segments(surface, other) {
            let (a, b) = (surface.uv(a), surface.uv(b));
            let Some((lo, hi)) = clip_line(&surface.outline, a, b) else { continue };
            let segment = [a + (b - a) * lo, a + (b - a) * hi];
            let long_enough = (segment[1] - segment[0]).length() > TOUCH;
            if long_enough && !on_outline(surface, &segment) && !cuts.iter().any(|c| same_line(c, &segment)) {
                cuts.push(segment);
            }
        }
    }
    cuts
}

/// Where `other` meets the plane of `surface`: its edges that lie in the plane or hover along it, or the line where it
/// goes through.
fn touching_segments(surface: &Surface, other: &Surface) -> Vec<(DVec3, DVec3)> {
    let heights: Vec<f64> = other.vertices.iter().map(|p| surface.height(*p)).collect();
    let n = heights.len();
    let hover = (HOVER_WIDTHS * other.extent.min_element()).clamp(TOUCH, HOVER);
    let flat = |k: usize| heights[k].abs() <= TOUCH;
    let mut segments = Vec::new();
    let mut crossings = Vec::new();
    for k in 0..n {
        let m = (k + 1) % n;
        let (a, b) = (other.vertices[k], other.vertices[m]);
        let hovers = heights[k].abs().max(heights[m].abs()) <= hover && (heights[k] - heights[m]).abs() <= TOUCH;
        if hovers {
            segments.push((a, b));
        } else if flat(k) {
            crossings.push(a);
        } else if !flat(m) && (heights[k] > 0.0) != (heights[m] > 0.0) {
            crossings.push(a + (b - a) * (heights[k] / (heights[k] - heights[m])));
        }
    }
    if segments.is_empty()
        && let [a, b] = crossings[..]
    {
        segments.push((a, b));
    }
    segments
}

fn on_outline(surface: &Surface, segment: &[DVec2; 2]) -> bool {
    let n = surface.outline.len();
    (0..n).any(|k| {
        let (p, q) = (surface.outline[k], surface.outline[(k + 1) % n]);
        segment.iter().all(|s| distance_to_line(*s, p, q) <= 2.0 * TOUCH)
    })
}

fn same_line(a: &[DVec2; 2], b: &[DVec2; 2]) -> bool {
    let inside = |s: DVec2| {
        let d = a[1] - a[0];
        let t = (s - a[0]).dot(d) / d.length_squared();
        (-1e-6..=1.0 + 1e-6).contains(&t)
    };
    b.iter().all(|s| distance_to_line(*s, a[0], a[1]) <= 2.0 * TOUCH && inside(*s))
}

fn distance_to_line(s: DVec2, p: DVec2, q: DVec2) -> f64 {
    let d = q - p;
    d.perp_dot(s - p).abs() / d.length().max(1e-300)
}
