//! Small files of each family, written from the descriptions of the formats. They are also the
//! seeds of the fuzz targets.

use std::path::Path;

use populace_trajectory::{Format, ReadSettings, Recording, Track, parse};

/// A family with a file.
pub(crate) struct Fixture {
    pub(crate) name: &'static str,
    pub(crate) format: Format,
    pub(crate) bytes: Vec<u8>,
}

/// Two people with headers as PeTrack writes them, one of whom looks back.
pub(crate) const PETRACK: &str = "\
# PeTrack project: door.pet
# framerate: 12.5 fps
# id frame x/cm y/cm z/cm viewDirX viewDirY markerID
1 10 100 200 176 0 1 999
1 11 105 200 178 0 0 999
2 10 -50.5 0 165 -1 0 7
2 11 -50.5 4 165 -1 0 7
";

pub(crate) const JPSCORE: &str = "\
#description: jpscore (0.8.4)
#agents: 2
#framerate: 8.00
#geometry: stairs_geometry.xml
#ID\tFR\tX\tY\tZ\tA\tB\tANGLE\tCOLOR
1\t0\t1.00\t0.50\t0.00\t0.18\t0.25\t180.00\t0\t
2\t0\t3.00\t0.50\t1.50\t0.18\t0.25\t-90.00\t255\t
1\t1\t0.90\t0.50\t0.10\t0.18\t0.25\t180.00\t20\t
2\t1\t3.00\t0.40\t1.60\t0.18\t0.25\t-90.00\t255\t
";

pub(crate) const VISWALK: &str = "\
$VISION
* File: station.inpx
* Date: 2026-05-02
$PEDESTRIAN:SIMSEC;NO;COORDCENTX;COORDCENTY;COORDCENTZ;SPEED;PEDTYPE\\NAME
0.20;1;4.5;2.5;0.0;4.9;Man
0.40;1;4.5;2.7;0.0;4.9;Man
0.40;2;8.5;2.5;3.5;0.0;Woman
0.60;1;4.5;2.9;0.0;4.9;Man
0.60;2;8.5;2.6;3.5;0.2;Woman
";

pub(crate) const CROWD_IT: &str = "\
\u{feff}pedID,time,posX,posY
0,0.0,1.0,2.0
1,0.0,NaN,NaN
0,0.5,1.5,2.5
1,0.5,3.0,4.0
1,1.0,3.5,4.0
";

pub(crate) const PATHFINDER: &str = "\
\"t\",\"id\",\"name\",\"active\",\"x\",\"y\",\"z\",\"v\",\"distance\",\"location\",\"terrain type\"
\"s\",\"\",\"\",\"\",\"m\",\"m\",\"m\",\"m/s\",\"m\",\"\",\"\"
0.0,0,\"00000, first\",0,0.0,0.0,0.0,0.0,0.0,\"\",\"\"
1.0,0,\"00000, first\",1,5.0,1.0,3.2,1.1,0.0,\"Hall, north\",\"level\"
2.0,0,\"00000, first\",1,6.1,1.0,3.0,1.1,1.1,\"Stairs 1\",\"stairs\"
1.0,1,\"00001\",1,5.0,3.0,0.0,1.2,0.0,\"Lobby\",\"level\"
2.0,1,\"00001\",1,6.2,3.0,0.0,1.2,1.2,\"Lobby\",\"level\"
";

pub(crate) const OBSMAT: &str = "\
 7.800000e+02   1.000000e+00   8.456844e+00   0.0   3.588066e+00   1.671320e+00   0.0   3.1e-01
 7.860000e+02   1.000000e+00   9.125372e+00   0.0   3.712066e+00   1.671320e+00   0.0   3.1e-01
 7.860000e+02   2.000000e+00   1.364021e+01   0.0   5.802000e+00  -1.936000e+00   0.0  -0.2e-01
 7.920000e+02   1.000000e+00   9.793900e+00   0.0   3.836066e+00   1.671320e+00   0.0   3.1e-01
 7.920000e+02   2.000000e+00   1.286581e+01   0.0   5.794000e+00  -1.936000e+00   0.0  -0.2e-01
";

pub(crate) const TRAJNET: &str = "\
780 1 8.46 3.59
790 1 9.57 3.79
800 1 10.67 3.99
790 2 13.64 5.80
800 2 12.09 5.75
810 2 ? ?
";

pub(crate) const TRAJNET_PLUS_PLUS: &str = "\
{\"scene\": {\"id\": 266, \"p\": 254, \"s\": 10238, \"e\": 10358, \"fps\": 2.5, \"tag\": 2}}
{\"track\": {\"f\": 10238, \"p\": 248, \"x\": 13.2, \"y\": 5.85}}
{\"track\": {\"f\": 10244, \"p\": 248, \"x\": 13.0, \"y\": 5.35}}
{\"track\": {\"f\": 10238, \"p\": 254, \"x\": 1.2, \"y\": 5.85}}
{\"track\": {\"f\": 10244, \"p\": 254, \"x\": 1.5, \"y\": 5.35}}
{\"track\": {\"f\": 10250, \"p\": 254, \"x\": 9.9, \"y\": 9.9, \"prediction_number\": 0}}
";

pub(crate) const CSV: &str = "\
time;ped_id;pos_x [cm];pos_y [cm];heading_deg;group;zone
0,00;A;100,5;20;90;1;hall
0,00;B;300;20;-90;2;hall
0,04;A;100,5;25;90;1;door
0,04;B;300;15;-90;staff;
";

pub(crate) const SUMO: &str = "\
timestep_time;vehicle_id;vehicle_x;vehicle_y;vehicle_angle;person_id;person_x;person_y;person_angle
0.00;;;;;0;1.00;2.00;90.00
0.00;0;50.0;3.2;0.00;;;;
1.00;;;;;0;2.30;2.00;90.00
1.00;0;50.0;9.2;0.00;;;;
2.00;;;;;;;;
";

/// Returns a file of Menge: two agents in two frames, with these numbers for each.
pub(crate) fn menge(version: &str, numbers: usize) -> Vec<u8> {
    let mut bytes = version.as_bytes().to_vec();
    bytes.push(0);
    bytes.extend(2_i32.to_le_bytes());
    if version != "1.0" {
        bytes.extend(0.05_f32.to_le_bytes());
    }
    bytes.extend([4_u32, 9].iter().flat_map(|class| class.to_le_bytes()));
    for frame in 0..2_u8 {
        for agent in 0..2_u8 {
            let first = 10.0 * f32::from(agent) + f32::from(frame);
            let values = (0..numbers).map(|index| first + 0.25 * index as f32);
            bytes.extend(values.flat_map(f32::to_le_bytes));
        }
    }
    bytes
}

pub(crate) fn all() -> Vec<Fixture> {
    let text = |name, format, text: &str| Fixture { name, format, bytes: text.into() };
    let mut all = vec![
        text("petrack", Format::PeTrack, PETRACK),
        text("jpscore", Format::Jpscore, JPSCORE),
        text("viswalk", Format::Viswalk, VISWALK),
        text("crowdit", Format::CrowdIt, CROWD_IT),
        text("pathfinder", Format::PathfinderCsv, PATHFINDER),
        text("obsmat", Format::Obsmat, OBSMAT),
        text("trajnet", Format::TrajNet, TRAJNET),
        text("trajnet++", Format::TrajNetPlusPlus, TRAJNET_PLUS_PLUS),
        text("csv", Format::Csv, CSV),
        text("sumo-csv", Format::Csv, SUMO),
    ];
    for (version, numbers) in
        [("1.0", 3), ("2.0", 3), ("2.1", 4), ("2.2", 8), ("2.3", 4), ("2.4", 4)]
    {
        let bytes = menge(version, numbers);
        all.push(Fixture { name: "menge", format: Format::Menge, bytes });
    }
    all
}

pub(crate) fn read(bytes: impl Into<Vec<u8>>) -> Result<Recording, populace_trajectory::Error> {
    parse(Path::new("file"), bytes.into(), &ReadSettings::default())
}

pub(crate) fn recording(bytes: impl Into<Vec<u8>>) -> Recording {
    read(bytes).unwrap_or_else(|error| panic!("{error}"))
}

/// Returns the message of the error that a file must give.
pub(crate) fn error(bytes: impl Into<Vec<u8>>) -> String {
    match read(bytes) {
        Ok(recording) => panic!("read as {}", recording.source.format),
        Err(error) => error.to_string(),
    }
}

/// Returns the rows of the agent with an id.
pub(crate) fn track<'a>(recording: &'a Recording, id: &str) -> Track<'a> {
    let agent = recording.agents.iter().find(|agent| agent.id == id);
    recording.track(agent.unwrap_or_else(|| panic!("no agent {id}")))
}
