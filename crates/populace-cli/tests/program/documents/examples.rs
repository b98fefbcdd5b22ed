//! The same two people in a file of each family.

use std::fmt::Write as _;
use std::path::Path;

use rusqlite::Connection;

/// Rows a second.
const RATE: u32 = 10;

/// A row: who, the number of the frame, and where in metres.
struct Row {
    id: u32,
    frame: u32,
    x: f64,
    y: f64,
}

/// Two people who pass each other within 3 s.
fn rows() -> Vec<Row> {
    let along = |frame: u32| 0.12 * f64::from(frame);
    let both = |frame: u32| {
        [
            Row { id: 1, frame, x: 1.0 + along(frame), y: 2.0 },
            Row { id: 2, frame, x: 4.6 - along(frame), y: 3.2 },
        ]
    };
    (0..=30).flat_map(both).collect()
}

impl Row {
    fn secs(&self) -> f64 {
        f64::from(self.frame) / f64::from(RATE)
    }
}

/// A file by its name, and what makes its text.
type Example = (&'static str, fn() -> String);

const EXAMPLES: [Example; 13] = [
    ("experiment.txt", || {
        let line =
            |r: &Row| format!("{} {} {:.2} {:.2} 176", r.id, r.frame, 100.0 * r.x, 100.0 * r.y);
        table("# framerate: 10 fps\n# id frame x/cm y/cm z/cm", line)
    }),
    ("uo-180.txt", || {
        table("", |r| format!("{} {} {:.2} {:.2} 176", r.id, r.frame, 100.0 * r.x, 100.0 * r.y))
    }),
    ("old-jupedsim.txt", || {
        let line = |r: &Row| format!("{}\t{}\t{}\t{}\t0\t0.2\t0.2\t0\t0", r.id, r.frame, r.x, r.y);
        table("#framerate: 10.00\n#ID\tFR\tX\tY\tZ\tA\tB\tANGLE\tCOLOR", line)
    }),
    ("postvis.traj", steps),
    ("fcd.xml", floating_car_data),
    ("stairs.csv", || {
        let line = |r: &Row| format!("{},{},\"{}\",1,{},{},0.0", r.secs(), r.id, r.id, r.x, r.y);
        table(
            concat!(
                "\"t\",\"id\",\"name\",\"active\",\"x\",\"y\",\"z\"\n",
                "\"s\",\"\",\"\",\"\",\"m\",\"m\",\"m\""
            ),
            line,
        )
    }),
    ("stairs.json", || {
        let agent = |id: u32| {
            let mut entries: Vec<String> = Vec::new();
            for r in rows().iter().filter(|row| row.id == id) {
                entries.push(format!(
                    "\"{}\": {{\"position\": {{\"x\": {}, \"y\": {}, \"z\": 0}}}}",
                    r.secs(),
                    r.x,
                    r.y
                ));
            }
            format!("\"{id}\": {{{}}}", entries.join(", "))
        };
        format!("{{{}, {}}}", agent(1), agent(2))
    }),
    ("station.pp", || {
        table("$VISION\n$PEDESTRIAN:SIMSEC;NO;COORDCENTX;COORDCENTY", |r| {
            format!("{};{};{};{}", r.secs(), r.id, r.x, r.y)
        })
    }),
    ("evacuation.csv", || {
        table("pedID,time,posX,posY", |r| format!("{},{},{},{}", r.id, r.secs(), r.x, r.y))
    }),
    ("obsmat.txt", || {
        // Rows are 10 frames of 25 a second apart, and 0.12 m.
        table("", |r| {
            let speed = if r.id == 1 { 0.3 } else { -0.3 };
            format!("{} {} {} 0 {} {speed} 0 0", 10 * r.frame, r.id, r.x, r.y)
        })
    }),
    ("trajnet.txt", || table("", |r| format!("{} {} {} {}", 10 * r.frame, r.id, r.x, r.y))),
    ("trajnet.ndjson", || {
        table("{\"scene\": {\"id\": 1, \"p\": 1, \"s\": 0, \"e\": 300, \"fps\": 2.5}}", |r| {
            format!(
                "{{\"track\": {{\"f\": {}, \"p\": {}, \"x\": {}, \"y\": {}}}}}",
                10 * r.frame,
                r.id,
                r.x,
                r.y
            )
        })
    }),
    ("mine.csv", || {
        table("person,time,x_cm,y_cm,group", |r| {
            format!("{},{},{},{},A", r.id, r.secs(), 100.0 * r.x, 100.0 * r.y)
        })
    }),
];

/// Files that are no text, and one that is no recording.
const OTHERS: [&str; 3] = ["bottleneck.sqlite", "walk.scb", "hall.wkt"];

/// Returns the names of all files.
pub(super) fn names() -> impl Iterator<Item = &'static str> {
    EXAMPLES.iter().map(|(name, _)| *name).chain(OTHERS)
}

/// Writes all files to a folder.
pub(super) fn write(folder: &Path) {
    for (name, text) in EXAMPLES {
        std::fs::write(folder.join(name), text()).expect("written");
    }
    let area = "POLYGON ((0 0, 6 0, 6 5, 0 5, 0 0))";
    std::fs::write(folder.join("hall.wkt"), area).expect("written");
    std::fs::write(folder.join("walk.scb"), menge()).expect("written");
    jupedsim(&folder.join("bottleneck.sqlite"), area);
}

fn table(head: &str, line: impl Fn(&Row) -> String) -> String {
    let lines: Vec<String> = rows().iter().map(line).collect();
    let head = if head.is_empty() { String::new() } else { format!("{head}\n") };
    format!("{head}{}\n", lines.join("\n"))
}

/// Returns footsteps of Vadere: from each position to that half a second later.
fn steps() -> String {
    let rows = rows();
    let mut text =
        "pedestrianId simTime endTime-PID1 startX-PID1 startY-PID1 endX-PID1 endY-PID1\n"
            .to_owned();
    for from in rows.iter().filter(|row| row.frame % 5 == 0) {
        let until = rows.iter().find(|row| row.id == from.id && row.frame == from.frame + 5);
        let Some(until) = until else { continue };
        writeln!(
            text,
            "{} {} {} {} {} {} {}",
            from.id,
            from.secs(),
            until.secs(),
            from.x,
            from.y,
            until.x,
            until.y
        )
        .expect("written");
    }
    text
}

fn floating_car_data() -> String {
    let mut text = "<fcd-export>\n".to_owned();
    for both in rows().chunks(2) {
        writeln!(text, "<timestep time=\"{:.2}\">", both[0].secs()).expect("written");
        for r in both {
            let angle = if r.id == 1 { 90 } else { 270 };
            writeln!(
                text,
                "<person id=\"{}\" x=\"{}\" y=\"{}\" angle=\"{angle}\"/>",
                r.id, r.x, r.y
            )
            .expect("written");
        }
        text += "</timestep>\n";
    }
    text + "</fcd-export>\n"
}

/// Returns a file of Menge: version 2.0 with x, y and heading of each agent in each frame.
fn menge() -> Vec<u8> {
    let mut bytes = b"2.0\0".to_vec();
    bytes.extend(2_i32.to_le_bytes());
    bytes.extend(0.1_f32.to_le_bytes());
    bytes.extend([0_u8; 8]);
    for r in rows() {
        let heading = if r.id == 1 { 0.0 } else { std::f64::consts::PI };
        for number in [r.x, r.y, heading] {
            #[expect(clippy::cast_possible_truncation, reason = "the file has f32")]
            bytes.extend((number as f32).to_le_bytes());
        }
    }
    bytes
}

fn jupedsim(path: &Path, area: &str) {
    let database = Connection::open(path).expect("a file");
    let tables = "
        CREATE TABLE trajectory_data(frame INTEGER, id INTEGER, pos_x REAL, pos_y REAL, ori_x REAL,
            ori_y REAL);
        CREATE TABLE metadata(key TEXT, value TEXT);
        CREATE TABLE geometry(hash INTEGER, wkt TEXT);
        CREATE TABLE frame_data(frame INTEGER, geometry_hash INTEGER);
        INSERT INTO metadata VALUES ('version', '2'), ('fps', '10');";
    database.execute_batch(tables).expect("tables");
    let insert = format!("INSERT INTO geometry VALUES (1, '{area}')");
    database.execute_batch(&insert).expect("an area");
    for Row { id, frame, x, y } in rows() {
        let ahead = if id == 1 { 1 } else { -1 };
        let rows = format!(
            "INSERT INTO trajectory_data VALUES ({frame}, {id}, {x}, {y}, {ahead}, 0);
             INSERT INTO frame_data SELECT {frame}, 1 WHERE {id} = 1;"
        );
        database.execute_batch(&rows).expect("rows");
    }
}
