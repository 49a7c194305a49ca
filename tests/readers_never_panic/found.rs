//! Files that once broke a reader, and what is right for them.

/// Reader, file, and is it to be accepted?
pub(crate) const FOUND: [(&str, &[u8], bool); 10] = [
    // Angles so close that a slope between them is no number: they are one angle.
    ("ies", b"TILT=NONE\n1 1000 1 3 1 2 1 0 0 0\n1 1 50\n-90 0 1e-308\n0 45\n0 9 0\n0 7 0\n", false),
    // Planes all round with a wide last step: written as EULUMDAT they end before 360°.
    (
        "ies",
        b"TILT=NONE\n1 -1 2 2 5 1 2 0.1 1.2 0.05\n1 1 20\n0 90\n0 90 180 240 360\n9 5\n9 6\n9 5\n9 6\n9 5\n",
        true,
    ),
    // A maker called TILT=NONE, after what is blank in EULUMDAT: the file that is written from it is one all the same.
    (
        "ies",
        b"[MANUFAC] \0TILT=NONE\nTILT=NONE\n1 1000 1 2 1 1 2 0.1 0.1 0\n1 1 9\n0 90\n0\n9 0\n",
        true,
    ),
    // More candelas than a file can hold.
    ("ies", b"TILT=NONE\n1 1000 1e9 2 1 1 1 0 0 0\n1e9 1 50\n0 90\n0\n9 0\n", false),
    // Ten thousand million lamps of 1,000 lm: more than EULUMDAT, which states them together, can be read with.
    ("ies", b"TILT=NONE\n9999999999 1000 1 2 1 1 2 0.1 0.1 0\n1 1 9\n0 90\n0\n9 0\n", true),
    // An opening as wide as a planet's orbit.
    ("ies", b"TILT=NONE\n1 1000 1 2 1 1 2 1e11 1 0\n1 1 50\n0 90\n0\n9 0\n", false),
    // 4e17 hours from UTC: taken off day by day, for ever.
    (
        "wea",
        b"place x\nlatitude 52\nlongitude -13\ntime_zone -5988112262444925135\nsite_elevation 34\n\
          weather_data_file_units 1\n3 21 10.5 300 90\n",
        false,
    ),
    // Values whose sum is infinite, and whose inverse is.
    ("spectrum", b"wavelength_nm,value\n400,1e308\n700,1e308\n", false),
    ("spectrum", b"wavelength_nm,value\n400,1e-320\n700,1e-320\n", false),
    // A number written as an entity lies nowhere in the document: its line could not be told.
    (
        "bsdf",
        b"<WindowElement><DataDefinition><IncidentDataStructure>Columns</IncidentDataStructure></DataDefinition>\
          <WavelengthData><Wavelength>Visible</Wavelength><WavelengthDataBlock><WavelengthDataDirection>Transmission \
          Front</WavelengthDataDirection><ColumnAngleBasis>LBNL/Klems Quarter</ColumnAngleBasis><RowAngleBasis>LBNL/Klems \
          Quarter</RowAngleBasis><ScatteringData>0.1,&#48;x</ScatteringData></WavelengthDataBlock></WavelengthData>\
          </WindowElement>",
        false,
    ),
];
