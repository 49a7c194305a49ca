//! What a careful reader would say of a result.

use super::result::{Measurement, Status};
use crate::scene::Scene;

/// What in a result was hardly meant: points without a reading, grids and pictures without light.
#[must_use]
pub fn remarks(scene: &Scene, m: &Measurement) -> Vec<String> {
    buried(m).chain(dark(scene, m)).collect()
}

/// Points inside solids: they have no reading.
fn buried(m: &Measurement) -> impl Iterator<Item = String> {
    m.grids.iter().filter_map(|g| {
        let inside = g.sensors.iter().filter(|s| s.status == Status::Inside).count();
        let of = g.sensors.len();
        (inside > 0)
            .then(|| format!("grid {:?}: {inside} of {of} points lie inside a solid and have no reading", g.name))
    })
}

/// Grids and pictures without any light, although something shines.
fn dark(scene: &Scene, m: &Measurement) -> impl Iterator<Item = String> {
    let emits = |i: usize| scene.materials[i].emission.as_ref().is_some_and(|e| e.radiance.max() > 0.0);
    let shines = scene.daytime.is_some() || scene.faces.iter().any(|f| emits(f.material));
    let black = |xyz: &[f32; 3]| xyz[1] == 0.0;
    let grids = m.grids.iter().filter_map(move |g| {
        let mut lit = g.sensors.iter().filter(|s| s.status == Status::Ok).peekable();
        (shines && lit.peek().is_some() && lit.all(|s| s.xyz[1] == 0.0)).then(|| format!("grid {:?}", g.name))
    });
    let views =
        m.views.iter().filter(move |v| shines && v.xyz.iter().all(black)).map(|v| format!("view {:?}", v.view.name));
    grids.chain(views).map(|what| {
        format!(
            "{what} gets no light at all, although something shines: light leaves the fronts of faces (right-hand rule); \
             is a lamp wound the wrong way, or walled in?"
        )
    })
}
