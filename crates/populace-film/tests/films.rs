//! Films are written, read back and compared with the frames that they were made of.
#![expect(clippy::unwrap_used, reason = "a step that fails fails the test")]

use std::path::Path;

use populace_film::{
    Encoder, Error, Film, FilmSettings, Pixels, decode_png, encode_png, write_png,
};

/// Returns a frame: a slope of colours, and a white square that moves.
fn frame([width, height]: [u32; 2], number: u32) -> Vec<u8> {
    let pixel = |x: u32, y: u32| {
        let inside = (4 * number..4 * number + 16).contains(&x) && (8..24).contains(&y);
        let slope = |at: u32, side: u32| u8::try_from(40 + 150 * at / side).unwrap();
        if inside { [255; 4] } else { [slope(x, width), slope(y, height), 90, 255] }
    };
    (0..height).flat_map(|y| (0..width).flat_map(move |x| pixel(x, y))).collect()
}

fn settings(size: [u32; 2], rate: &str) -> FilmSettings {
    FilmSettings::new(size, rate.parse().unwrap())
}

fn write(path: &Path, settings: &FilmSettings, count: u32) -> Result<Film, Error> {
    let mut film = Film::create(path, settings)?;
    for number in 0..count {
        film.push(frame(settings.size, number))?;
    }
    Ok(film)
}

fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<_> =
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[cfg(feature = "openh264")]
mod mp4 {
    use openh264::decoder::Decoder;
    use openh264::formats::YUVSource;
    use populace_film::FrameRate;

    use super::*;

    /// A box: its letters and contents.
    struct Found<'a>([u8; 4], &'a [u8]);

    fn number(bytes: &[u8], at: usize) -> u32 {
        u32::from_be_bytes(bytes[at..at + 4].try_into().unwrap())
    }

    fn long(bytes: &[u8], at: usize) -> u64 {
        u64::from_be_bytes(bytes[at..at + 8].try_into().unwrap())
    }

    /// Returns the boxes side by side in `bytes`, which they fill.
    fn boxes(mut bytes: &[u8]) -> Vec<Found<'_>> {
        let mut found = Vec::new();
        while !bytes.is_empty() {
            let name = bytes[4..8].try_into().unwrap();
            let (header, size) = match number(bytes, 0) {
                1 => (16, usize::try_from(long(bytes, 8)).unwrap()),
                size => (8, size as usize),
            };
            let (first, rest) = bytes.split_at(size);
            found.push(Found(name, &first[header..]));
            bytes = rest;
        }
        found
    }

    /// Returns the contents of the box at a path such as `moov/trak`.
    fn at<'a>(mut bytes: &'a [u8], path: &str) -> &'a [u8] {
        for name in path.split('/') {
            let inside = boxes(bytes);
            bytes = inside.iter().find(|found| found.0 == *name.as_bytes()).unwrap().1;
        }
        bytes
    }

    /// Returns the H.264 of frames with start codes, after the parameter sets of the `avcC` box.
    fn stream(file: &[u8], frames: &[&[u8]]) -> Vec<Vec<u8>> {
        let stsd = at(file, "moov/trak/mdia/minf/stbl/stsd");
        let entry = &at(&stsd[8..], "avc1")[78..];
        let avcc = at(entry, "avcC");
        assert_eq!((avcc[0], avcc[1], avcc[4], avcc[5]), (1, 100, 0xff, 0xe1), "version, High");
        let length = |at: usize| usize::from(u16::from_be_bytes([avcc[at], avcc[at + 1]]));
        let sequence = &avcc[8..8 + length(6)];
        let picture_at = 8 + sequence.len() + 3;
        let picture = &avcc[picture_at..picture_at + length(picture_at - 2)];
        let mut begin = Vec::new();
        for set in [sequence, picture] {
            begin.extend([0, 0, 0, 1]);
            begin.extend(set);
        }
        let annex_b = |frame: &&[u8]| {
            let (mut rest, mut out) = (*frame, Vec::new());
            while !rest.is_empty() {
                let (unit, after) = rest[4..].split_at(number(rest, 0) as usize);
                out.extend([0, 0, 0, 1]);
                out.extend(unit);
                rest = after;
            }
            out
        };
        std::iter::once(begin).chain(frames.iter().map(annex_b)).collect()
    }

    /// Decodes a stream and compares each picture with its frame.
    fn compare(stream: &[Vec<u8>], [width, height]: [u32; 2]) {
        let mut decoder = Decoder::new().unwrap();
        let mut pictures = 0;
        for bytes in stream {
            let Some(picture) = decoder.decode(bytes).unwrap() else { continue };
            let even = [width, height].map(|side| side.next_multiple_of(2) as usize);
            assert_eq!(picture.dimensions(), even.into());
            let (row, _, _) = picture.strides();
            let wanted = frame([width, height], pictures);
            let mut sum = 0.0;
            for (index, pixel) in wanted.chunks_exact(4).enumerate() {
                let [x, y] = [index % width as usize, index / width as usize];
                let [r, g, b] = [pixel[0], pixel[1], pixel[2]].map(f64::from);
                let bright = 16.0 + 219.0 / 255.0 * (0.2126 * r + 0.7152 * g + 0.0722 * b);
                sum += (f64::from(picture.y()[y * row + x]) - bright).abs();
            }
            let mean = sum / f64::from(width * height);
            assert!(mean < 2.0, "frame {pictures} differs by {mean}");
            pictures += 1;
        }
        assert_eq!(pictures as usize, stream.len() - 1);
    }

    /// Returns the frames that the tables of an ordinary file name.
    fn frames_of(file: &[u8]) -> Vec<&[u8]> {
        let table = at(file, "moov/trak/mdia/minf/stbl");
        let [sizes, chunks, places] = ["stsz", "stsc", "co64"].map(|name| at(table, name));
        let sizes: Vec<usize> =
            (0..number(sizes, 8) as usize).map(|i| number(sizes, 12 + 4 * i) as usize).collect();
        let mut frames = Vec::new();
        let count = number(chunks, 4) as usize;
        assert_eq!(count, number(places, 4) as usize);
        for chunk in 0..count {
            assert_eq!(number(chunks, 8 + 12 * chunk) as usize, chunk + 1);
            let mut begin = usize::try_from(long(places, 8 + 8 * chunk)).unwrap();
            for _ in 0..number(chunks, 12 + 12 * chunk) {
                let size = sizes[frames.len()];
                frames.push(&file[begin..begin + size]);
                begin += size;
            }
        }
        assert_eq!(frames.len(), sizes.len());
        frames
    }

    #[test]
    fn a_whole_film_has_its_tables_in_front_and_shows_the_frames() {
        for (size, rate, ticks) in [
            ([96, 64], "10", [10_240, 1024]),
            ([97, 33], "30000/1001", [30_000, 1001]),
            ([16, 17], "0.5", [16_384, 32_768]),
        ] {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("film.mp4");
            let film = write(&path, &settings(size, rate), 23).unwrap();
            assert_eq!(film.finish().unwrap(), path);
            assert_eq!(names(folder.path()), ["film.mp4"]);
            let file = std::fs::read(&path).unwrap();
            let order: Vec<_> = boxes(&file).iter().map(|found| found.0).collect();
            assert_eq!(order, [*b"ftyp", *b"moov", *b"mdat"]);
            let header = at(&file, "moov/trak/mdia/mdhd");
            let [scale, frame_time] = ticks;
            let wanted = (scale, 23 * u64::from(frame_time));
            assert_eq!((number(header, 20), long(header, 24)), wanted, "{rate}");
            let times = at(&file, "moov/trak/mdia/minf/stbl/stts");
            assert_eq!([4, 8, 12].map(|at| number(times, at)), [1, 23, frame_time]);
            let track = at(&file, "moov/trak/tkhd");
            let sides = [track.len() - 8, track.len() - 4].map(|at| number(track, at) >> 16);
            assert_eq!(sides, size.map(|side| side.next_multiple_of(2)));
            let keys = at(&file, "moov/trak/mdia/minf/stbl/stss");
            let every = rate.parse::<FrameRate>().unwrap().per_sec().round().max(1.0);
            assert_eq!(f64::from(number(keys, 4)), (23.0 / every).ceil(), "a key frame a second");
            compare(&stream(&file, &frames_of(&file)), size);
        }
    }

    #[test]
    fn a_part_holds_whole_fragments_and_shows_its_frames() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("film.mp4");
        std::fs::write(&path, "an older film").unwrap();
        let settings = settings([96, 64], "10");
        drop(write(&path, &settings, 25).unwrap());
        assert_eq!(names(folder.path()), ["film.mp4", "film.part.mp4"]);
        assert_eq!(std::fs::read(&path).unwrap(), b"an older film");
        let part = std::fs::read(folder.path().join("film.part.mp4")).unwrap();
        let order: Vec<_> = boxes(&part).iter().map(|found| found.0).collect();
        let pair = [*b"moof", *b"mdat"];
        assert_eq!(order, [vec![*b"ftyp", *b"moov"], pair.repeat(3)].concat());
        let (mut frames, mut begun) = (Vec::new(), 0);
        let mut place = 0;
        for found in boxes(&part) {
            if found.0 == *b"moof" {
                let fragment = at(found.1, "traf");
                assert_eq!(long(at(fragment, "tfdt"), 4), 1024 * begun);
                let run = at(fragment, "trun");
                let mut begin = place + number(run, 8) as usize;
                for index in 0..number(run, 4) as usize {
                    let size = number(run, 12 + 8 * index) as usize;
                    let is_key = number(run, 16 + 8 * index) == 0x0200_0000;
                    assert_eq!(is_key, index == 0, "only the first frame is a key frame");
                    frames.push(&part[begin..begin + size]);
                    begin += size;
                    begun += 1;
                }
                assert_eq!(
                    begin,
                    place + found.1.len() + 8 + 8 + {
                        let data = number(&part, place + 8 + found.1.len()) as usize;
                        data - 8
                    }
                );
            }
            place += found.1.len() + 8;
        }
        assert_eq!(begun, 25);
        compare(&stream(&part, &frames), settings.size);
    }

    #[test]
    fn the_same_frames_give_the_same_bytes() {
        let folder = tempfile::tempdir().unwrap();
        let films = ["a.mp4", "b.mp4"].map(|name| {
            let film = write(&folder.path().join(name), &settings([64, 48], "25"), 30).unwrap();
            std::fs::read(film.finish().unwrap()).unwrap()
        });
        assert!(films[0] == films[1]);
    }

    #[test]
    fn a_smaller_quantizer_gives_a_larger_film() {
        let folder = tempfile::tempdir().unwrap();
        let sizes = [10, 40].map(|quantizer| {
            let settings = FilmSettings { quantizer, ..settings([96, 64], "25") };
            let film = write(&folder.path().join("a.mp4"), &settings, 30).unwrap();
            std::fs::metadata(film.finish().unwrap()).unwrap().len()
        });
        assert!(2 * sizes[0] > 3 * sizes[1], "{sizes:?}");
    }

    #[test]
    fn sizes_beyond_the_encoder_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        for (size, name) in [([3842, 100], "3842x100"), ([15, 64], "15x64")] {
            let refused = write(&folder.path().join("a.mp4"), &settings(size, "25"), 0);
            let message = refused.unwrap_err().to_string();
            assert!(message.contains(name) && message.contains("3840x2160"), "{message}");
        }
        assert!(names(folder.path()).is_empty());
    }

    /// `/dev/full` is a full disk.
    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_disk_is_reported_by_push_or_finish() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("film.mp4");
        std::os::unix::fs::symlink("/dev/full", folder.path().join("film.part.mp4")).unwrap();
        for count in [1, 100] {
            let error = write(&path, &settings([96, 64], "10"), count).and_then(Film::finish);
            let error = error.unwrap_err();
            assert!(error.to_string().contains("film.part.mp4"), "{error}");
            let reason = std::error::Error::source(&error).unwrap().to_string();
            assert!(reason.contains("space"), "{reason}");
        }
    }
}

/// Returns a frame of many colours: a wide slope of the sky, on which somebody moves whose
/// clothes are coloured and whose hair is dark.
fn busy_frame([width, height]: [u32; 2], number: u32) -> Vec<u8> {
    let byte = |value: u32| u8::try_from(value % 256).unwrap();
    let pixel = |x: u32, y: u32| {
        let from_left = x.wrapping_sub(5 * number + 4);
        let shade = byte((x * 7 + y * 13) % 16);
        match (from_left, y) {
            (0..12, 20..32) => [60 + shade, 30 + shade, 20, 255],
            (0..12, 32..56) => [180 + shade, 30, 50 + shade, 255],
            (0..12, 56..60) => [20, 60 + shade, 200, 255],
            (0..12, 60..88) => [30, 110 + shade, 40 + shade, 255],
            _ => [byte(120 + x / 2), byte(150 + y / 2), byte(200 + (x + y) / 5), 255],
        }
    };
    (0..height).flat_map(|y| (0..width).flat_map(move |x| pixel(x, y))).collect()
}

#[test]
fn gifs_leave_no_trails_and_keep_the_colours_of_what_moves() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("film.gif");
    let settings = settings([160, 96], "25");
    let mut film = Film::create(&path, &settings).unwrap();
    for number in 0..24 {
        film.push(busy_frame(settings.size, number)).unwrap();
    }
    film.finish().unwrap();
    let mut options = gif::DecodeOptions::new();
    options.set_color_output(gif::ColorOutput::RGBA);
    let mut reader = options.read_info(std::fs::File::open(&path).unwrap()).unwrap();
    let mut shown = vec![0; 160 * 96 * 4];
    for number in 0..24 {
        let found = reader.read_next_frame().unwrap().unwrap();
        for (pixel, new) in shown.chunks_exact_mut(4).zip(found.buffer.chunks_exact(4)) {
            if new[3] != 0 {
                pixel.copy_from_slice(new);
            }
        }
        let wanted = busy_frame(settings.size, number);
        let apart = || shown.iter().zip(&wanted).map(|(a, b)| a.abs_diff(*b));
        let mean = apart().map(f64::from).sum::<f64>() / (160.0 * 96.0 * 3.0);
        let most = apart().max().unwrap();
        assert!(mean < 3.0 && most < 16, "frame {number} differs by {mean}, at most {most}");
    }
}

#[test]
fn gifs_show_the_frames_at_their_times() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("film.gif");
    let settings = settings([96, 64], "30");
    let film = write(&path, &settings, 10).unwrap();
    assert_eq!(film.part(), folder.path().join("film.part.gif"));
    film.finish().unwrap();
    assert_eq!(names(folder.path()), ["film.gif"]);
    let mut options = gif::DecodeOptions::new();
    options.set_color_output(gif::ColorOutput::RGBA);
    let mut reader = options.read_info(std::fs::File::open(&path).unwrap()).unwrap();
    let (mut shown, mut hundredths, mut count) = (frame(settings.size, 0), 0, 0);
    while let Some(found) = reader.read_next_frame().unwrap() {
        assert_eq!((found.width, found.height, found.left, found.top), (96, 64, 0, 0));
        for (pixel, new) in shown.chunks_exact_mut(4).zip(found.buffer.chunks_exact(4)) {
            if new[3] != 0 {
                pixel.copy_from_slice(new);
            }
        }
        let wanted = frame(settings.size, count);
        let sum: u32 = shown.iter().zip(&wanted).map(|(a, b)| u32::from(a.abs_diff(*b))).sum();
        let mean = f64::from(sum) / wanted.len() as f64;
        assert!(mean < 4.0, "frame {count} differs by {mean}");
        hundredths += u32::from(found.delay);
        count += 1;
    }
    assert_eq!((count, hundredths), (10, 33), "10 frames of 1/30 s");
    let refused = Film::create(&path, &FilmSettings { rate: "60".parse().unwrap(), ..settings });
    assert!(refused.unwrap_err().to_string().contains("1/655 to 50"));
    Film::create(&path, &FilmSettings { rate: "1/655".parse().unwrap(), ..settings }).unwrap();
    let refused = Film::create(&path, &FilmSettings { rate: "1/656".parse().unwrap(), ..settings });
    assert!(refused.unwrap_err().to_string().contains("1/655 to 50"));
}

#[test]
fn wrong_names_sizes_and_frames_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let refused = |name: &str, size| {
        let film = write(&path(name), &settings(size, "25"), 0);
        film.and_then(Film::finish).unwrap_err().to_string()
    };
    assert!(refused("film.avi", [8, 8]).contains(".mp4 or .gif"));
    assert!(refused("film.gif", [0, 8]).contains("0x8"));
    assert!(refused("film.gif", [8, 8]).contains("no frame"));
    assert!(refused("missing/film.gif", [8, 8]).contains("film.part.gif"));
    let bad = FilmSettings { quantizer: 52, ..settings([8, 8], "25") };
    assert!(Film::create(path("film.gif"), &bad).unwrap_err().to_string().contains("0 to 51"));
    let mut film = write(&path("film.gif"), &settings([8, 8], "25"), 1).unwrap();
    assert!(film.push(vec![0; 12]).unwrap_err().to_string().contains("has 12 bytes"));
    film.push(vec![0; 256]).unwrap();
    assert_eq!(film.frame_count(), 2);
    film.finish().unwrap();
    assert_eq!(names(folder.path()), ["film.gif"], "parts without frames are removed");
}

/// Builds on machines with ffmpeg run it; others see how its absence is reported.
#[test]
fn ffmpeg_writes_the_film_or_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("film.mp4");
    let settings = FilmSettings { encoder: Encoder::Ffmpeg, ..settings([97, 64], "25") };
    match write(&path, &settings, 30).and_then(Film::finish) {
        Ok(_) => {
            let file = std::fs::read(&path).unwrap();
            assert_eq!(&file[4..8], b"ftyp");
            assert_eq!(names(folder.path()), ["film.mp4"]);
        }
        Err(error) => {
            let message = error.to_string();
            assert!(message.contains("install it") && message.contains("PATH"), "{message}");
            assert!(names(folder.path()).is_empty());
        }
    }
}

#[test]
fn pngs_hold_all_bits() {
    let gray = [0u16, 1, 256, 65535];
    let bytes = encode_png([2, 2], Pixels::Gray16(&gray)).unwrap();
    let read = image::load_from_memory(&bytes).unwrap();
    assert_eq!(read.as_luma16().unwrap().as_raw(), &gray);
    let bytes = encode_png([1, 1], Pixels::Rgba(&[1, 2, 3, 4])).unwrap();
    assert_eq!(image::load_from_memory(&bytes).unwrap().as_rgb8().unwrap().as_raw(), &[1, 2, 3]);
    let bytes = encode_png([3, 1], Pixels::Gray(&[0, 128, 255])).unwrap();
    assert_eq!(
        image::load_from_memory(&bytes).unwrap().as_luma8().unwrap().as_raw(),
        &[0, 128, 255]
    );
    let error = write_png("no-such-folder/picture.png", [1, 1], Pixels::Gray(&[0])).unwrap_err();
    assert!(error.to_string().contains("no-such-folder/picture.png"), "{error}");
    let message = encode_png([2, 1], Pixels::Gray(&[0])).unwrap_err().to_string();
    assert!(message.contains("2x1"), "{message}");
    assert!(encode_png([0, 0], Pixels::Gray(&[])).is_err());
    for (size, given, words) in [
        ([2, 2], 12, "has 12 bytes; it needs 16"),
        ([2, 2], 18, "has 18 bytes; it needs 16"),
        ([u32::MAX; 2], 4, "has 4 bytes"),
    ] {
        let message = encode_png(size, Pixels::Rgba(&vec![0; given])).unwrap_err().to_string();
        assert!(message.contains(words), "{message}");
    }
}

#[test]
fn pngs_are_read_as_they_were_written() {
    let rgba = frame([40, 30], 3);
    let file = encode_png([40, 30], Pixels::Rgba(&rgba)).unwrap();
    assert_eq!(decode_png(&file).unwrap(), ([40, 30], rgba));
    let gray = encode_png([1, 2], Pixels::Gray16(&[0, 65535])).unwrap();
    assert_eq!(decode_png(&gray).unwrap(), ([1, 2], vec![0, 0, 0, 255, 255, 255, 255, 255]));
    for broken in [&b""[..], b"GIF89a", &file[..file.len() / 2]] {
        let error = decode_png(broken).unwrap_err();
        assert!(matches!(error, Error::BadPng { .. }), "{error}");
    }
}
