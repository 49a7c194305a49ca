//! The two arrangements as geometry: boards by number, size, angle, spacing and paint. Metres, y up, the viewer at
//! negative z.

use glam::DVec3;

/// A named polygon with its paint, counter-clockwise seen from its front.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    pub name: String,
    pub paint: String,
    pub corners: [DVec3; 4],
}

/// A row of boards that stand on a black base.
#[derive(Clone, Debug)]
pub(crate) struct Boards {
    /// Paint of the hidden side of each board, from -x to +x: their number is that of the boards.
    pub paints: Vec<&'static str>,
    pub width_m: f64,
    pub height_m: f64,
    pub thickness_m: f64,
    /// By which the fronts are turned from the viewer, about the vertical.
    pub angle_deg: f64,
    /// From middle to middle.
    pub spacing_m: f64,
    /// Is the narrow side that looks to the viewer white?
    pub white_edge: bool,
}

/// A light of 4000 cd/m² and the rest of an arrangement.
#[derive(Clone, Debug)]
pub(crate) struct Design {
    pub name: &'static str,
    pub boards: Boards,
    /// Corner and sides of the base, of the light (its front along `u × v`) and of a white backing.
    pub base: [DVec3; 3],
    pub sky: [DVec3; 3],
    pub backing: Option<[DVec3; 3]>,
}

const COLOURS: [&str; 6] = ["red", "yellow", "green", "cyan", "blue", "magenta"];

fn at(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

/// Boards turned by 45° before a window: fronts see light that has been reflected twice at least.
pub(crate) fn louvre() -> Design {
    Design {
        name: "louvre",
        boards: Boards {
            paints: COLOURS.to_vec(),
            width_m: 0.10,
            height_m: 0.40,
            thickness_m: 0.006,
            angle_deg: 45.0,
            spacing_m: 0.07,
            white_edge: true,
        },
        base: [at(-0.35, 0.0, -0.25), at(0.0, 0.0, 0.80), at(0.70, 0.0, 0.0)],
        sky: [at(-0.25, 0.0, 0.6), at(0.0, 0.70, 0.0), at(0.70, 0.0, 0.0)],
        backing: None,
    }
}

/// Boards before a white panel that is lit from a slot above.
pub(crate) fn backing() -> Design {
    Design {
        name: "backing",
        boards: Boards {
            paints: COLOURS.to_vec(),
            width_m: 0.06,
            height_m: 0.40,
            thickness_m: 0.006,
            angle_deg: 0.0,
            spacing_m: 0.10,
            white_edge: false,
        },
        base: [at(-0.35, 0.0, -0.25), at(0.0, 0.0, 0.37), at(0.70, 0.0, 0.0)],
        sky: [at(-0.32, 0.60, 0.012), at(0.64, 0.0, 0.0), at(0.0, 0.0, 0.100)],
        backing: Some([at(-0.32, 0.0, 0.12), at(0.0, 0.40, 0.0), at(0.64, 0.0, 0.0)]),
    }
}

impl Boards {
    /// Where the fronts look, and the direction across them from the viewer's edge to the other one.
    pub(crate) fn axes(&self) -> (DVec3, DVec3) {
        let (sin, cos) = self.angle_deg.to_radians().sin_cos();
        (at(-sin, 0.0, -cos), at(-cos, 0.0, sin))
    }

    /// Middle of board `i` on the base.
    pub(crate) fn middle(&self, i: usize) -> DVec3 {
        at((i as f64 - 0.5 * (self.paints.len() - 1) as f64) * self.spacing_m, 0.0, 0.0)
    }

    fn parts(&self, i: usize) -> Vec<Part> {
        let (normal, across) = self.axes();
        let (n, t, up) = (normal * (0.5 * self.thickness_m), across * (0.5 * self.width_m), DVec3::Y * self.height_m);
        let m = self.middle(i);
        let colour = self.paints[i];
        let side = |name: &str, paint: &str, from: DVec3, to: DVec3| Part {
            name: format!("board{i}_{name}"),
            paint: paint.into(),
            corners: [from, to, to + up, from + up],
        };
        let viewer = if self.white_edge { "white" } else { colour };
        vec![
            side("front", "white", m + n - t, m + n + t),
            side("back", colour, m - n + t, m - n - t),
            side("edge_viewer", viewer, m - n - t, m + n - t),
            side("edge_window", colour, m + n + t, m - n + t),
            Part {
                name: format!("board{i}_top"),
                paint: "black".into(),
                corners: [m + n - t, m + n + t, m - n + t, m - n - t].map(|p| p + up),
            },
        ]
    }
}

impl Design {
    pub(crate) fn parts(&self) -> Vec<Part> {
        let sheet = |name: &str, paint: &str, [corner, u, v]: [DVec3; 3]| Part {
            name: name.into(),
            paint: paint.into(),
            corners: [corner, corner + u, corner + u + v, corner + v],
        };
        let mut all: Vec<Part> = (0..self.boards.paints.len()).flat_map(|i| self.boards.parts(i)).collect();
        all.push(sheet("base", "black", self.base));
        all.push(sheet("sky", "sky", self.sky));
        all.extend(self.backing.map(|b| sheet("backing", "white", b)));
        all
    }

    /// The 60 points of the measurement: surface, place and normal. On fronts where there is no backing.
    pub(crate) fn points(&self) -> Vec<(String, DVec3, DVec3)> {
        if let Some([corner, ..]) = self.backing {
            let place = |k: usize| at(-0.275 + 0.05 * (k / 5) as f64, 0.04 + 0.08 * (k % 5) as f64, corner.z);
            return (0..60).map(|k| ("backing".to_owned(), place(k), DVec3::NEG_Z)).collect();
        }
        let (normal, across) = self.boards.axes();
        let mut all = Vec::new();
        for board in 1..self.boards.paints.len() {
            let front = self.boards.middle(board) + normal * (0.5 * self.boards.thickness_m);
            for offset_m in [-0.035, 0.0, 0.035] {
                for height_m in [0.05, 0.15, 0.25, 0.35] {
                    let p = front + across * offset_m + DVec3::Y * height_m;
                    all.push((format!("board{board}_front"), p, normal));
                }
            }
        }
        all
    }
}
