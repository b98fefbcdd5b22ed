//! SQLite of JuPedSim, versions 1 to 3: `trajectory_data`, `metadata`, `geometry`, `frame_data`.

use std::path::Path;

use rusqlite::types::ValueRef;
use rusqlite::{Connection, OpenFlags, OptionalExtension, Row};

use crate::areas::Areas;
use crate::extra::Extras;
use crate::ids::Ids;
use crate::input::Input;
use crate::rows::{Clock, Found, Rows};
use crate::{Error, Fact, Format, Location, Place, ReadSettings, Recording, Unit};

/// Bytes of a file's header that say if it is written through a log beside it, and the value of
/// those that are not.
const WRITE_AHEAD: (std::ops::Range<usize>, u8) = (18..20, 1);

pub(crate) fn read(input: &Input, settings: &ReadSettings) -> Result<Recording, Error> {
    let mut rows = Rows::default();
    let database = Database { connection: open(input, &mut rows)?, input };
    database.require_table("trajectory_data")?;
    let told = database.metadata("fps")?.and_then(|text| text.trim().parse::<f64>().ok());
    let fps = match (told, settings.fps) {
        (Some(fps), _) => Fact::of_file(fps),
        (None, Some(fps)) => Fact::assumed(fps),
        (None, None) => {
            return Err(Error::Missing {
                path: input.path().to_owned(),
                what: "the frame rate (fps in the table metadata)",
                remedy: "--data-fps N sets it".to_owned(),
            });
        }
    };
    database.read_rows(&mut rows)?;
    let place = database.place(fps.unless_set(settings.fps).value, &mut rows)?;
    let version = database.metadata("version")?.map_or(String::new(), |v| format!("version {v}"));
    let format = (Format::JuPedSim, version);
    let found =
        Found { format, unit: Fact::of_file(Unit::Metres), clock: Clock::Frames(fps), place };
    rows.finish(found, input.path(), settings)
}

/// Opens a file without writing anything beside it, or bytes in memory.
fn open(input: &Input, rows: &mut Rows) -> Result<Connection, Error> {
    let broken = |error: rusqlite::Error| refused(input, None, &error);
    let on_disk = input.plain_on_disk()?.and_then(|path| Some((path, address(path)?)));
    let connection = if let Some((path, address)) = on_disk {
        for (end, what) in [("-wal", "log"), ("-journal", "journal")] {
            let beside = format!("{}{end}", path.display());
            if std::fs::metadata(&beside).is_ok_and(|file| file.len() > 0) {
                rows.warnings.whole(format!(
                    "changes in the {what} {beside} were not read; its program must finish, or \
                     sqlite3 must open the file once, to merge them"
                ));
            }
        }
        let flags = OpenFlags::SQLITE_OPEN_READ_ONLY
            | OpenFlags::SQLITE_OPEN_URI
            | OpenFlags::SQLITE_OPEN_NO_MUTEX;
        Connection::open_with_flags(address, flags).map_err(broken)?
    } else {
        let mut bytes = Vec::new();
        std::io::copy(&mut input.open()?, &mut bytes).map_err(input.unreadable())?;
        if let Some(modes) = bytes.get_mut(WRITE_AHEAD.0) {
            modes.fill(WRITE_AHEAD.1);
        }
        let mut connection = Connection::open_in_memory().map_err(broken)?;
        let count = bytes.len();
        connection.deserialize_read_exact("main", &*bytes, count, true).map_err(broken)?;
        connection
    };
    // Tables of a file that need not be trusted may name functions and damaged cells.
    connection.pragma_update(None, "trusted_schema", false).map_err(broken)?;
    connection.pragma_update(None, "cell_size_check", true).map_err(broken)?;
    Ok(connection)
}

/// Returns the address by which SQLite opens a file as one that nobody changes, so that it needs
/// neither locks nor files beside it.
fn address(path: &Path) -> Option<String> {
    let mut text = path.to_str()?.to_owned();
    if cfg!(windows) {
        text = text.replace('\\', "/");
        if text.chars().nth(1) == Some(':') {
            text.insert(0, '/');
        }
    }
    let mut address = "file:".to_owned();
    for c in text.chars() {
        match c {
            '%' => address.push_str("%25"),
            '?' => address.push_str("%3f"),
            '#' => address.push_str("%23"),
            c => address.push(c),
        }
    }
    // Two slashes at the start would be taken for the name of a machine.
    let address = address.replacen("file://", "file:////", 1);
    Some(address + "?immutable=1")
}

fn refused(input: &Input, at: Option<Location>, error: &rusqlite::Error) -> Error {
    input.malformed(
        at,
        format!(
            "SQLite cannot read it ({error}); if the file is complete, `sqlite3` may repair it"
        ),
    )
}

/// The columns of `trajectory_data` with a meaning.
const COLUMNS: [&str; 6] = ["frame", "id", "pos_x", "pos_y", "ori_x", "ori_y"];

struct Database<'a> {
    connection: Connection,
    input: &'a Input,
}

impl Database<'_> {
    fn broken(&self) -> impl Fn(rusqlite::Error) -> Error + '_ {
        |error| refused(self.input, None, &error)
    }

    /// Returns the names of the tables. Views are left out: reading one may take forever.
    fn tables(&self) -> Result<Vec<String>, Error> {
        let sql = "SELECT name FROM sqlite_schema WHERE type = 'table' AND rootpage > 0";
        let mut query = self.connection.prepare(sql).map_err(self.broken())?;
        let names = query.query_map([], |row| row.get(0)).map_err(self.broken())?;
        names.collect::<Result<_, _>>().map_err(self.broken())
    }

    fn has_table(&self, name: &str) -> Result<bool, Error> {
        Ok(self.tables()?.iter().any(|table| table.eq_ignore_ascii_case(name)))
    }

    fn require_table(&self, name: &str) -> Result<(), Error> {
        if self.has_table(name)? {
            return Ok(());
        }
        let tables = self.tables()?.join(", ");
        Err(self.input.malformed(
            None,
            format!("has no table {name}, so JuPedSim did not write it; its tables: {tables}"),
        ))
    }

    /// Returns the names of a table's columns.
    fn columns(&self, table: &str) -> Result<Vec<String>, Error> {
        let sql = "SELECT name FROM pragma_table_info(?1)";
        let mut query = self.connection.prepare(sql).map_err(self.broken())?;
        let names = query.query_map([table], |row| row.get(0)).map_err(self.broken())?;
        names.collect::<Result<_, _>>().map_err(self.broken())
    }

    /// Returns a value of the table `metadata` as text.
    fn metadata(&self, key: &str) -> Result<Option<String>, Error> {
        if !self.has_table("metadata")? {
            return Ok(None);
        }
        let sql = "SELECT CAST(value AS TEXT) FROM metadata WHERE key = ?1";
        let value = self.connection.query_row(sql, [key], |row| row.get(0)).optional();
        Ok(value.map_err(self.broken())?.flatten())
    }

    fn read_rows(&self, rows: &mut Rows) -> Result<(), Error> {
        let columns = self.columns("trajectory_data")?;
        let place = |name: &str| columns.iter().position(|c| c.eq_ignore_ascii_case(name));
        let [frame, id, x, y, ori_x, ori_y] = COLUMNS.map(place);
        let (Some(frame), Some(id), Some(x), Some(y)) = (frame, id, x, y) else {
            let problem = format!(
                "the table trajectory_data needs the columns frame, id, pos_x and pos_y; it has {}",
                columns.join(", ")
            );
            return Err(self.input.malformed(None, problem));
        };
        let (mut extras, mut ids) = (Extras::default(), Ids::default());
        let others: Vec<(usize, usize)> = (columns.iter().enumerate())
            .filter(|(_, name)| !COLUMNS.iter().any(|known| name.eq_ignore_ascii_case(known)))
            .filter_map(|(index, name)| Some((index, extras.index(name, rows)?)))
            .collect();
        let quoted: Vec<_> =
            columns.iter().map(|name| format!("\"{}\"", name.replace('"', "\"\""))).collect();
        let sql = format!("SELECT {} FROM trajectory_data", quoted.join(", "));
        let mut query = self.connection.prepare(&sql).map_err(self.broken())?;
        let mut found = query.query([]).map_err(self.broken())?;
        for number in 1.. {
            let at = Some(Location::Row(number));
            let next = found.next().map_err(|error| refused(self.input, at, &error))?;
            let Some(row) = next else { break };
            let Some(agent) = agent(&mut ids, rows, value(row, id)) else {
                rows.leave_out("rows without an id were left out", at);
                continue;
            };
            let at_m = [number_of(value(row, x)), number_of(value(row, y))];
            rows.push(agent, number_of(value(row, frame)), at_m, at);
            if let (Some(x), Some(y)) = (ori_x, ori_y) {
                rows.set_heading_vector([x, y].map(|column| number_of(value(row, column))));
            }
            for (column, extra) in &others {
                let extra = extras.get(*extra);
                match value(row, *column) {
                    ValueRef::Text(text) => {
                        extra.set_word(rows, &String::from_utf8_lossy(text));
                    }
                    ValueRef::Null | ValueRef::Blob(_) => {}
                    number => extra.set_number(rows, number_of(number)),
                }
            }
        }
        Ok(())
    }

    fn place(&self, fps: f64, rows: &mut Rows) -> Result<Place, Error> {
        if !self.has_table("geometry")? {
            return Ok(Place::default());
        }
        let columns = self.columns("geometry")?;
        let has = |name: &str| columns.iter().any(|column| column.eq_ignore_ascii_case(name));
        if !has("wkt") {
            rows.warnings.whole("the table geometry has no column wkt, so the area is not known");
            return Ok(Place::default());
        }
        let hash = if has("hash") { "hash" } else { "0" };
        let sql = format!("SELECT {hash}, wkt FROM geometry");
        let texts =
            self.pairs(&sql, |row| (whole(value(row, 0)).unwrap_or(0), text(value(row, 1))))?;
        let changes = texts.len() > 1;
        let areas = Areas::parse(texts, &mut rows.warnings);
        let by_frame = has("hash") && self.has_table("frame_data")?;
        let frames = if by_frame && changes {
            let sql = "SELECT frame, geometry_hash FROM frame_data ORDER BY CAST(frame AS REAL)";
            self.pairs(sql, |row| (number_of(value(row, 0)) / fps, whole(value(row, 1))))?
        } else {
            Vec::new()
        };
        let mut known = Vec::with_capacity(frames.len());
        for (secs, hash) in frames {
            if let Some(hash) = hash {
                known.push((secs, hash));
            } else {
                let text = "frames without the hash of a walkable area keep the one before";
                rows.warnings.row(text, None);
            }
        }
        Ok(areas.place(&known, &mut rows.warnings))
    }

    fn pairs<A, B>(
        &self,
        sql: &str,
        pair: impl Fn(&Row<'_>) -> (A, B),
    ) -> Result<Vec<(A, B)>, Error> {
        let mut query = self.connection.prepare(sql).map_err(self.broken())?;
        let found = query.query_map([], |row| Ok(pair(row))).map_err(self.broken())?;
        found.collect::<Result<_, _>>().map_err(self.broken())
    }
}

/// Returns the value in a column that the query has.
fn value<'a>(row: &'a Row<'_>, column: usize) -> ValueRef<'a> {
    row.get_ref(column).unwrap_or(ValueRef::Null)
}

/// Returns a value as a number; NaN if it is none.
fn number_of(value: ValueRef<'_>) -> f64 {
    match value {
        #[expect(clippy::cast_precision_loss, reason = "frames are far below 2^53")]
        ValueRef::Integer(integer) => integer as f64,
        ValueRef::Real(real) => real,
        ValueRef::Text(text) => {
            std::str::from_utf8(text).ok().and_then(|t| t.trim().parse().ok()).unwrap_or(f64::NAN)
        }
        ValueRef::Null | ValueRef::Blob(_) => f64::NAN,
    }
}

/// Returns a value as a whole number; nothing if it is none.
fn whole(value: ValueRef<'_>) -> Option<i64> {
    match value {
        ValueRef::Integer(integer) => Some(integer),
        ValueRef::Text(text) => std::str::from_utf8(text).ok()?.trim().parse().ok(),
        ValueRef::Real(_) | ValueRef::Null | ValueRef::Blob(_) => None,
    }
}

/// Returns a value as text; nothing if it is none.
fn text(value: ValueRef<'_>) -> String {
    match value {
        ValueRef::Text(text) => String::from_utf8_lossy(text).into_owned(),
        _ => String::new(),
    }
}

/// Returns the agent with an id of any type.
fn agent(ids: &mut Ids, rows: &mut Rows, id: ValueRef<'_>) -> Option<u32> {
    match id {
        ValueRef::Integer(id) => Some(ids.agent(id, rows)),
        ValueRef::Real(id) => Some(rows.agent(&id.to_string())),
        ValueRef::Text(id) if !id.is_empty() => Some(rows.agent(&String::from_utf8_lossy(id))),
        ValueRef::Text(_) | ValueRef::Null | ValueRef::Blob(_) => None,
    }
}
