//! HDF5 of JuPedSim, PeTrack and the Jülich archive: the table `/trajectory`.

use std::io::Write;

use rust_hdf5::{FileLocking, H5Attribute, H5Dataset, H5File, LinkClass};

use crate::areas::Areas;
use crate::extra::Extras;
use crate::ids::Ids;
use crate::input::Input;
use crate::rows::{Clock, Found, Rows};
use crate::{Error, Fact, Format, Location, Place, ReadSettings, Recording, Unit};

mod people;
mod table;

use people::{Details, Views};
use table::Table;

/// Members of `/trajectory` with a meaning.
const MEMBERS: [&str; 7] = ["id", "frame", "x", "y", "z", "ox", "oy"];

/// Most walkable areas of a file.
const MOST_AREAS: usize = 4096;

pub(crate) fn read(input: &Input, settings: &ReadSettings) -> Result<Recording, Error> {
    let file = Hdf5::open(input)?;
    let Some(dataset) = file.dataset("trajectory")? else {
        let has = file.file.dataset_names().join(", ");
        return Err(file.refused(&format!("it has no dataset trajectory, but {has}")));
    };
    let fps = frame_rate(&file, &dataset, settings)?;
    let unit = unit(&dataset);
    let table = file.table(&dataset, "trajectory")?;
    let mut rows = Rows::default();
    file.read_rows(&table, &mut rows)?;
    let place = file.place(fps.unless_set(settings.fps).value, &mut rows)?;
    let version = file.version();
    let found = Found { format: (Format::Hdf5, version), unit, clock: Clock::Frames(fps), place };
    rows.finish(found, input.path(), settings)
}

/// Returns the frame rate that the table or the file states.
fn frame_rate(
    file: &Hdf5<'_>,
    dataset: &H5Dataset,
    settings: &ReadSettings,
) -> Result<Fact<f64>, Error> {
    let told = dataset.attr("fps").ok().and_then(|attribute| number(&attribute));
    match (told.or_else(|| file.root_number("fps")), settings.fps) {
        (Some(fps), _) => Ok(Fact::of_file(fps)),
        (None, Some(fps)) => Ok(Fact::assumed(fps)),
        (None, None) => Err(Error::Missing {
            path: file.input.path().to_owned(),
            what: "the frame rate (attribute fps of the dataset trajectory)",
            remedy: "--data-fps N sets it".to_owned(),
        }),
    }
}

/// Returns the unit of positions that JuPedSim states; metres if nothing is said, as the format has
/// it.
fn unit(dataset: &H5Dataset) -> Fact<Unit> {
    let text = dataset.attr("column_units").ok().and_then(|units| units.read_string().ok());
    let units = text.and_then(|text| serde_json::from_str::<serde_json::Value>(&text).ok());
    let told = units.as_ref().and_then(|units| units.get("x")?.as_str()?.parse().ok());
    Fact::of_file(told.unwrap_or(Unit::Metres))
}

/// Returns the number that an attribute holds, as a number or as text.
fn number(attribute: &H5Attribute) -> Option<f64> {
    #[expect(clippy::cast_precision_loss, reason = "frame rates are far below 2^53")]
    let integer = || Some(*attribute.read_numeric_as::<i64>().ok()?.first()? as f64);
    let float = || attribute.read_numeric_as::<f64>().ok()?.first().copied();
    let text = || attribute.read_string().ok()?.trim().parse().ok();
    float().or_else(integer).or_else(text)
}

struct Hdf5<'a> {
    file: H5File,
    input: &'a Input,
    bytes: u64,
    /// Holds the bytes of files that are not on disk as they are.
    _copy: Option<tempfile::NamedTempFile>,
}

impl<'a> Hdf5<'a> {
    fn open(input: &'a Input) -> Result<Self, Error> {
        let mut copy = None;
        let path = if let Some(path) = input.plain_on_disk()? {
            path.to_owned()
        } else {
            let mut file = tempfile::NamedTempFile::new().map_err(input.unreadable())?;
            std::io::copy(&mut input.open()?, &mut file).map_err(input.unreadable())?;
            file.flush().map_err(input.unreadable())?;
            copy.insert(file).path().to_owned()
        };
        let bytes = std::fs::metadata(&path).map_err(input.unreadable())?.len();
        let options = H5File::options().locking(FileLocking::Disabled);
        let file = options.open(&path).map_err(|error| refused(input, &error.to_string()))?;
        Ok(Self { file, input, bytes, _copy: copy })
    }

    fn refused(&self, reason: &str) -> Error {
        refused(self.input, reason)
    }

    /// Returns the dataset at a path, if the file has it and it is not in another file.
    fn dataset(&self, path: &str) -> Result<Option<H5Dataset>, Error> {
        let (group, name) = path.rsplit_once('/').unwrap_or(("", path));
        let root = self.file.root_group();
        let group = if group.is_empty() { Ok(root) } else { root.group(group) };
        let Ok(group) = group else { return Ok(None) };
        match group.link_class(name) {
            Ok(LinkClass::Hard | LinkClass::Soft { .. }) => {}
            Ok(_) => return Err(self.refused(&format!("{path} is in another file"))),
            Err(_) => return Ok(None),
        }
        let dataset = self.file.dataset(path).map_err(|error| self.refused(&error.to_string()))?;
        table::check_size(&dataset, self.bytes)
            .map_err(|reason| self.refused(&format!("dataset {path}: {reason}")))?;
        Ok(Some(dataset))
    }

    fn table(&self, dataset: &H5Dataset, name: &str) -> Result<Table, Error> {
        Table::read(dataset).map_err(|reason| self.refused(&format!("dataset {name}: {reason}")))
    }

    fn table_of(&self, path: &str) -> Result<Option<Table>, Error> {
        self.dataset(path)?.map(|dataset| self.table(&dataset, path)).transpose()
    }

    fn root_text(&self, name: &str) -> Option<String> {
        self.file.attr_string(name).ok()
    }

    fn root_number(&self, name: &str) -> Option<f64> {
        self.root_text(name)?.trim().parse().ok()
    }

    /// Returns the program that wrote the file.
    fn version(&self) -> String {
        let words = ["producer", "producer_version"].map(|name| self.root_text(name));
        words.into_iter().flatten().collect::<Vec<_>>().join(" ")
    }

    fn read_rows(&self, table: &Table, rows: &mut Rows) -> Result<(), Error> {
        let [id, frame, x, y, z, ox, oy] = MEMBERS.map(|name| table.member(name));
        let (Some(id), Some(frame), Some(x), Some(y)) = (id, frame, x, y) else {
            let has: Vec<_> = table.names().collect();
            let reason = format!(
                "dataset trajectory needs numbers id, frame, x and y; it has {}",
                has.join(", ")
            );
            return Err(self.refused(&reason));
        };
        // JuPedSim stores the ground's elevation, experiments that of heads or the body height.
        let has_ground = ox.is_some() || self.root_text("producer").as_deref() == Some("JuPedSim");
        let (mut extras, mut ids) = (Extras::default(), Ids::default());
        let others: Vec<(usize, usize)> = (table.names().enumerate())
            .filter(|(_, name)| !MEMBERS.iter().any(|known| name.eq_ignore_ascii_case(known)))
            .filter_map(|(member, name)| Some((member, extras.index(name, rows)?)))
            .collect();
        let views = self.table_of("petrack_data")?.and_then(Views::new);
        let mut details = self.table_of("personal_details")?.and_then(Details::new);
        for row in 0..table.len() {
            let at = Some(Location::Row(row as u64 + 1));
            let Some(number) = table.integer(row, id) else {
                rows.leave_out("rows without a whole number as id were left out", at);
                continue;
            };
            let agent = ids.agent(number, rows);
            let position = [table.number(row, x), table.number(row, y)];
            rows.push(agent, table.number(row, frame), position, at);
            let known_m = details.as_mut().and_then(|details| details.set(rows, number));
            match (z.map(|z| table.number(row, z)), known_m) {
                (Some(z), _) if has_ground => rows.set_elevation(z),
                (_, Some(height_m)) => rows.raise_height_m(agent, height_m),
                (Some(z), None) => rows.raise_height(agent, z),
                (None, None) => {}
            }
            if let (Some(x), Some(y)) = (ox, oy) {
                rows.set_heading_vector([table.number(row, x), table.number(row, y)]);
            }
            for (member, extra) in &others {
                extras.get(*extra).set_number(rows, table.number(row, *member));
            }
            if let (Some(views), Some(frame)) = (&views, table.integer(row, frame))
                && let Some(view_rad) = views.of(number, frame)
            {
                rows.set_view(view_rad);
            }
        }
        Ok(())
    }

    /// Returns the walkable area, with its changes.
    fn place(&self, fps: f64, rows: &mut Rows) -> Result<Place, Error> {
        let first = self.root_text("wkt_geometry").filter(|text| !text.trim().is_empty());
        let mut texts: Vec<(i64, String)> = Vec::new();
        let wkt = self.dataset("geometry/wkt")?;
        let hashes = self.dataset("geometry/hash")?;
        // Many texts may be the same bytes of the file.
        if wkt.as_ref().is_some_and(|wkt| wkt.total_elements() > MOST_AREAS) {
            rows.warnings.whole(format!("more than {MOST_AREAS} walkable areas were left out"));
        } else if let (Some(wkt), Some(hashes)) = (wkt, hashes) {
            let broken = |error: rust_hdf5::Hdf5Error| self.refused(&error.to_string());
            let hashes = hashes.read_numeric_as::<i64>().map_err(broken)?;
            let wkt = wkt.read_vlen_strings().or_else(|_| wkt.read_strings()).map_err(broken)?;
            texts.extend(hashes.into_iter().zip(wkt));
        }
        let frames = self.table_of("frame_geometry")?;
        let mut changes = Vec::new();
        // The first area holds until the first change.
        if let Some((hash, _)) = texts.first() {
            changes.push((0.0, *hash));
        } else if let Some(first) = first {
            texts.push((0, first));
        }
        if let Some(frames) = &frames
            && let Some(frame) = frames.member("frame")
            && let Some(hash) = frames.member("geometry_hash")
        {
            changes.extend((0..frames.len()).filter_map(|row| {
                Some((frames.number(row, frame) / fps, frames.integer(row, hash)?))
            }));
        }
        changes.sort_by(|a, b| a.0.total_cmp(&b.0));
        Ok(Areas::parse(texts, &mut rows.warnings).place(&changes, &mut rows.warnings))
    }
}

fn refused(input: &Input, reason: &str) -> Error {
    input.malformed(
        None,
        format!(
            "this HDF5 cannot be read ({reason}); if the file is complete, write it again with \
             h5py, as a table /trajectory of id, frame, x, y with the attribute fps"
        ),
    )
}
