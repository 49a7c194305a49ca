//! Small files of every kind, to begin with.

use std::path::Path;

fn shipped(name: &str) -> Vec<u8> {
    // The samples lie beside the tests' folder, wherever this file is compiled from.
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let root = if root.ends_with("fuzz") { root.join("..") } else { root.to_path_buf() };
    std::fs::read(root.join(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
}

pub(super) fn ies_samples() -> Vec<Vec<u8>> {
    let tilted = LAMP_IES.replace("TILT=NONE", "TILT=INCLUDE\n1\n3\n0 45 90\n1.0 0.95 0.9");
    let type_b = "IESNA:LM-63-1995\n[TEST] flood\nTILT=NONE\n1 1000 1 3 3 2 1 -0.5 0 0.1\n1 1 50\n-90 0 90\n0 45 90\n\
                  0 9 0\n0 7 0\n0 1 0\n";
    let absolute = "IES:LM-63-2019\n[LUMINAIRE] box\nTILT=NONE\n1 -1 2 3 5 1 2 0.1 1.2 0.05\n1 1.00001 20\n0 90 180\n\
                    0 90 180 270 360\n9 5 1\n9 6 1\n9 5 1\n9 6 1\n9 5 1\n";
    let mut all: Vec<Vec<u8>> =
        [LAMP_IES.into(), tilted, type_b.into(), absolute.into()].map(String::into_bytes).to_vec();
    all.extend(["pendant", "wall_washer", "projector"].map(|n| shipped(&format!("luminaires/{n}.ies"))));
    all
}

/// A short EULUMDAT file of a symmetry code, with so many planes of which some are stored.
fn short_eulumdat(isym: u32, planes: u32, stored: u32) -> Vec<u8> {
    let head = format!(
        "maker\n1\n{isym}\n{planes}\n{}\n3\n45\nr\nname\nn\nf\nd\n600\n600\n50\n500\n500\n0\n0\n0\n0\n100\n80\n1\n0\n1\n\
         1\nLED\n3600\n4000\n80\n40\n",
        360.0 / f64::from(planes)
    );
    let ratios = "0.5\n".repeat(10);
    let planes_deg: String = (0..planes).map(|k| format!("{}\n", 360.0 / f64::from(planes) * f64::from(k))).collect();
    (head + &ratios + &planes_deg + "0\n45\n90\n" + &"300\n200\n0\n".repeat(stored as usize)).into_bytes()
}

pub(super) fn eulumdat_samples() -> Vec<Vec<u8>> {
    let mut all: Vec<Vec<u8>> =
        [(0, 4, 4), (1, 1, 1), (2, 4, 3), (3, 4, 3), (4, 4, 2)].map(|(i, p, s)| short_eulumdat(i, p, s)).to_vec();
    all.extend(["linear", "wall_washer"].map(|n| shipped(&format!("luminaires/{n}.ldt"))));
    all
}

pub(super) fn epw_samples() -> Vec<Vec<u8>> {
    let mut text = String::from("LOCATION,Nowhere,-,-,made,000000,52.5,13.4,1.0,34.0\n");
    text += "DESIGN CONDITIONS,0\nTYPICAL/EXTREME PERIODS,0\nGROUND TEMPERATURES,0\n";
    text += "HOLIDAYS/DAYLIGHT SAVINGS,No,0,0,0\nCOMMENTS 1,none\nCOMMENTS 2,none\n";
    text += "DATA PERIODS,1,1,Data,Sunday, 1/ 1,12/31\n";
    let hour = |month: u32, day: u32, hour: u32| {
        format!("2001,{month},{day},{hour},0,?,10.0,5.0,70,101325,0,0,300,0,{hour},50{}\n", ",0".repeat(19))
    };
    let months = [31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];
    let year: String = (1..)
        .zip(months)
        .flat_map(|(m, days)| (1..=days).flat_map(move |d| (1..=24).map(move |h| hour(m, d, h))))
        .collect();
    // Two days of it too: the reader goes through all rows before it misses the rest.
    let short: String = year.split_inclusive('\n').take(48).collect();
    vec![(text.clone() + &year).into_bytes(), (text + &short).into_bytes()]
}

pub(super) fn wea_samples() -> Vec<Vec<u8>> {
    vec![WEA.into()]
}

pub(super) fn bsdf_samples() -> Vec<Vec<u8>> {
    let values = ["0.05"; 41 * 41].join(",");
    let block = |direction: &str| {
        format!(
            "<WavelengthData><Wavelength unit=\"Integral\">Visible</Wavelength><WavelengthDataBlock>\
             <WavelengthDataDirection>{direction}</WavelengthDataDirection><ColumnAngleBasis>LBNL/Klems Quarter\
             </ColumnAngleBasis><RowAngleBasis>LBNL/Klems Quarter</RowAngleBasis><ScatteringData>{values}\
             </ScatteringData></WavelengthDataBlock></WavelengthData>"
        )
    };
    let file = |blocks: &str| {
        format!(
            "<?xml version=\"1.0\"?><WindowElement><Optical><Layer><DataDefinition><IncidentDataStructure>Columns\
             </IncidentDataStructure></DataDefinition>{blocks}</Layer></Optical></WindowElement>"
        )
        .into_bytes()
    };
    let short = block("Transmission Front").replace(&values, "0.1, 0.2");
    vec![file(&(block("Transmission Front") + &block("Reflection Back"))), file(&short), file("")]
}

pub(super) fn spectrum_samples() -> Vec<Vec<u8>> {
    vec![SPECTRUM_CSV.into(), shipped("validation/cornell/light.csv")]
}

pub(super) fn obj_samples() -> Vec<Vec<u8>> {
    let concave =
        "o l\nv 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nusemtl wall\nf -6/1/1 -5//1 -4 -3 \\\n-2 -1\n";
    vec![ROOM_OBJ.into(), concave.into()]
}

pub(super) fn points_samples() -> Vec<Vec<u8>> {
    vec![POINTS.into(), b"1e3\t-2.5 0 0 1e-9 0\r\n\r\n0 0 1 1 1 1\n".to_vec()]
}

pub(super) fn schedule_samples() -> Vec<Vec<u8>> {
    vec![format!("occupied\n{}", "1\n0\n".repeat(4380)).into_bytes(), b"occupied\n1\n0\n".to_vec()]
}

pub(super) fn scene_samples() -> Vec<Vec<u8>> {
    vec![SCENE_TOML.into(), SCENE_2_TOML.into()]
}

pub(super) fn measured_samples() -> Vec<Vec<u8>> {
    vec![
        b"grid,point,illuminance_lx,uncertainty_lx,cie_x,cie_y,uncertainty_xy\ndesk,0,100,3,0.33,0.34,0.002\ndesk,1,90,3,,,\n"
            .to_vec(),
        ILLUMINANCE.into(),
        b"grid,point,status,illuminance_lx,error_lx,uncertainty_lx\na,0,ok,1e3,0,1\n".to_vec(),
    ]
}

pub(super) fn peer_samples() -> Vec<Vec<u8>> {
    vec![
        b"method,setting,cpu_s,wall_s,rays,form_factors,peak_mem_mb,rms_rel,mbe_rel,p95_rel,max_rel,stated_p95,coverage,\
          resolved\nother,-ab 3,1.5,0.8,1000,,64,0.02,0.001,0.05,0.1,,,true\n"
            .to_vec(),
    ]
}

pub(super) const ROOM_OBJ: &str = "# a room\nmtllib room.mtl\no room\nv 0 0 0\nv 4 0 0\nv 4 3 0\nv 0 3 0\nv 0 0 2.7\nv 4 0 2.7\nv 4 3 2.7\n\
    v 0 3 2.7\nv 1.7 1.2 2.6\nv 2.3 1.2 2.6\nv 2.3 1.8 2.6\nv 1.7 1.8 2.6\nusemtl wall\ng floor\nf 1 2 3 4\ng rest\n\
    f 8 7 6 5\nf 1 5 6 2\nf 2 6 7 3\nf 3 7 8 4\nusemtl pane\nf 4 8 5 1\nusemtl panel\nf 12 11 10 9\n";
pub(super) const POINTS: &str = "1 1 0.8 0 0 1\n2 1.5 0.8 0 0 1\n";
pub(super) const SPECTRUM_CSV: &str = "wavelength_nm,value\n400,0.4\n500,0.5\n600,0.6\n700,0.55\n";
pub(super) const LAMP_IES: &str = "IESNA:LM-63-2002\n[TEST] 1\n[LUMINAIRE] spot\n[MORE] of light\nTILT=NONE\n1 1000 1 5 1 1 2 -0.2 0 0\n\
    1 1 12\n0 22.5 45 67.5 90\n0\n320 300 220 120 0\n";
pub(super) const WEA: &str = "place Nowhere\nlatitude 52.50\nlongitude -13.40\ntime_zone -15\nsite_elevation 34.0\n\
    weather_data_file_units 1\n3 21 10.5 300 90\n3 21 11.5 320 95\n3 21 12.5 280 9999\n";
pub(super) const ILLUMINANCE: &str = "grid,point,x_m,y_m,z_m,status,illuminance_lx,error_lx,cie_x,cie_y\ndesk,0,1,1,0.8,ok,101,2,0.332,0.341\n\
    desk,1,2,1,0.8,ok,92,2,0.331,0.34\ndesk,2,3,1,0.8,covered,,,,\n";
pub(super) const SCENE_TOML: &str = r#"title = "A room"
[geometry]
files = ["room.obj"]
unit = "m"
up = "z"
north_deg = 10.0
[bands]
mode = { step_nm = 20, range_nm = [380, 780] }
[materials.wall]
reflectance = "wall.csv"
[materials.pane]
kind = "glass"
panes = [{ transmittance = 0.82, reflectance_front = 0.11, reflectance_back = 0.05 }, { transmittance = 0.9 }]
[materials.panel]
reflectance = [0.8, 0.7, 0.6]
emission = { flux_lm = 3600, spectrum = 4000, group = "panel" }
[sky]
model = "perez"
ground_reflectance = 0.2
[site]
weather = "place.wea"
time = "2026-03-21T11:40:00+01:00"
[annual]
hours = [8, 18]
[[blinds]]
panes = ["pane"]
transmittance = 0.05
control = "lm-83"
[[luminaires]]
file = "lamp.ies"
position_m = [1, 1, 2.5]
aim = [0.1, 0, -1]
rotation_deg = 30
columns = 2
column_spacing_m = [1, 0, 0]
multiplier = 0.9
maintenance_factor = 0.8
spectrum = "wall.csv"
group = "spot"
power_W = 12
ra = 80
[[grids]]
name = "desk"
points = "points.pts"
[[grids]]
name = "floor"
on = "floor"
spacing_m = 0.5
height_m = 0.8
inset_m = 0.5
cylindrical = true
ugr = true
requirement = { mean_lx = 500, uniformity = 0.6, ra = 80, ugr = 19 }
[[views]]
name = "camera"
position_m = [0.5, 0.5, 1.6]
direction = [1, 0.7, 0.2]
up = [0, 0, 1]
fov_deg = 80
pixels = [40, 30]
[[states]]
name = "half"
levels = { spot = 0.5 }
others = 0.2
daylight = false
[power]
floor = "floor"
grid = "floor"
"#;
pub(super) const SCENE_2_TOML: &str = r#"[geometry]
files = ["room.obj"]
unit = "ft"
up = "y"
[bands]
mode = "auto"
[materials.wall]
kind = "translucent"
transmittance = 0.3
reflectance = 0.5
outside = true
[materials.pane]
kind = "mirror"
reflectance = 0.9
[materials.panel]
reflectance = 0.8
reflectance_back = 0.2
emission = { luminance_cd_m2 = 1000, spectrum = "A", two_sided = true }
[sky]
model = "cie-12"
horizontal_illuminance_lx = 12000
direct_normal_illuminance_lx = 80000
sun_altitude_deg = 30
sun_azimuth_deg = 180
[[grids]]
name = "workplane"
plane = { origin_m = [0, 0, 0.85], u_m = [4, 0, 0], v_m = [0, 3, 0], nu = 16, nv = 12 }
normal = [0, 0, 1]
semicylindrical = [1, 0, 0]
emergency = { min_lx = 1, max_over_min = 40 }
[[views]]
name = "round"
position_m = [0.5, 0.5, 1.6]
direction = [0, 0, 1]
up = [0, 1, 0]
kind = "fisheye"
fov_deg = 180
pixels = [30, 30]
"#;
