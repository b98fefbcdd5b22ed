//! The track of a film: its header, its fragments, and the tables that say where its frames are.

use super::boxes::Boxes;
use crate::settings::FrameRate;

/// Least number of units of time per second, since some players round shorter rates.
const LEAST_TIMESCALE: u32 = 10_000;
/// Flags of a frame that needs no other.
const KEY_FLAGS: u32 = 0x0200_0000;
/// Flags of a frame that needs those before it.
const OTHER_FLAGS: u32 = 0x0101_0000;
/// A transform that changes nothing, in fixed point.
const UNIT_MATRIX: [u32; 9] = [0x1_0000, 0, 0, 0, 0x1_0000, 0, 0, 0, 0x4000_0000];
const TRACK_ID: u32 = 1;

/// A frame in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Sample {
    pub(crate) bytes: u32,
    /// True if it needs no other frame.
    pub(crate) is_key: bool,
}

/// Consecutive frames in a file.
struct Chunk {
    /// Place of the first byte in the fragmented file.
    begin: u64,
    bytes: u64,
    samples: u32,
}

/// The only track of a film.
pub(crate) struct Track {
    /// Width and height in pixels.
    size: [u16; 2],
    /// Units of time per second.
    timescale: u32,
    /// Units of time that a frame lasts.
    frame_time: u32,
    samples: Vec<Sample>,
    chunks: Vec<Chunk>,
}

impl Track {
    pub(crate) fn new(size: [u16; 2], rate: FrameRate) -> Self {
        let [frames, secs] = rate.fraction();
        let factor = LEAST_TIMESCALE.div_ceil(frames).next_power_of_two();
        let [timescale, frame_time] = [frames, secs].map(|n| n.saturating_mul(factor));
        Self { size, timescale, frame_time, samples: Vec::new(), chunks: Vec::new() }
    }

    /// Appends a frame.
    pub(crate) fn push(&mut self, sample: Sample) {
        self.samples.push(sample);
    }

    /// Returns the places of all frames in the fragmented file: first byte and number of bytes.
    pub(crate) fn chunks(&self) -> impl Iterator<Item = [u64; 2]> {
        self.chunks.iter().map(|chunk| [chunk.begin, chunk.bytes])
    }

    /// Returns the number of frames that are in fragments.
    fn in_chunks(&self) -> usize {
        self.chunks.iter().map(|chunk| chunk.samples as usize).sum()
    }

    /// Returns the beginning of a fragmented file, with the given parameter sets.
    pub(crate) fn fragmented_header(&self, sets: [&[u8]; 2]) -> Vec<u8> {
        let mut out = Boxes::default();
        file_type(&mut out);
        out.boxed(b"moov", |out| {
            self.movie_header(out, 0);
            self.track(out, 0, sets, |out| {
                for name in [b"stts", b"stsc", b"stco"] {
                    out.full(name, 0, 0, |out| _ = out.u32(0));
                }
                out.full(b"stsz", 0, 0, |out| _ = out.zeros(8));
            });
            out.boxed(b"mvex", |out| {
                out.full(b"trex", 0, 0, |out| {
                    out.u32(TRACK_ID).u32(1).u32(self.frame_time).u32(0).u32(OTHER_FLAGS);
                });
            });
        });
        out.0
    }

    /// Returns a fragment of the frames that are in none yet. It begins at byte `begin` of the
    /// file, and `frames` are their bytes.
    pub(crate) fn fragment(&mut self, begin: u64, frames: &[u8]) -> Vec<u8> {
        let first = self.in_chunks();
        let samples = &self.samples[first..];
        let count = u32::try_from(samples.len()).unwrap_or(u32::MAX);
        let number = u32::try_from(self.chunks.len()).unwrap_or(u32::MAX).saturating_add(1);
        let mut out = Boxes::default();
        let mut data_offset_at = 0;
        out.boxed(b"moof", |out| {
            out.full(b"mfhd", 0, 0, |out| _ = out.u32(number));
            out.boxed(b"traf", |out| {
                // Places are counted from the beginning of this box.
                out.full(b"tfhd", 0, 0x02_0000, |out| _ = out.u32(TRACK_ID));
                out.full(b"tfdt", 1, 0, |out| {
                    out.u64(first as u64 * u64::from(self.frame_time));
                });
                // The place of the frames, and for each its size and flags.
                out.full(b"trun", 0, 0x00_0601, |out| {
                    out.u32(count);
                    data_offset_at = out.0.len();
                    out.u32(0);
                    for sample in samples {
                        let flags = if sample.is_key { KEY_FLAGS } else { OTHER_FLAGS };
                        out.u32(sample.bytes).u32(flags);
                    }
                });
            });
        });
        let data_offset = u32::try_from(out.0.len() + 8).unwrap_or(u32::MAX);
        out.0[data_offset_at..data_offset_at + 4].copy_from_slice(&data_offset.to_be_bytes());
        out.boxed(b"mdat", |out| _ = out.bytes(frames));
        let begin = begin + u64::from(data_offset);
        self.chunks.push(Chunk { begin, bytes: frames.len() as u64, samples: count });
        out.0
    }

    /// Returns the beginning of an ordinary file, up to the first byte of the frames, which follow
    /// chunk by chunk.
    pub(crate) fn whole_header(&self, sets: [&[u8]; 2]) -> Vec<u8> {
        // The places of frames depend on the length of the header, which is the same for all.
        let length = self.whole_header_at(0, sets).len() as u64;
        self.whole_header_at(length, sets)
    }

    fn whole_header_at(&self, begin: u64, sets: [&[u8]; 2]) -> Vec<u8> {
        let duration = self.samples.len() as u64 * u64::from(self.frame_time);
        let mut out = Boxes::default();
        file_type(&mut out);
        out.boxed(b"moov", |out| {
            self.movie_header(out, duration);
            self.track(out, duration, sets, |out| self.sample_tables(out, begin));
        });
        let bytes: u64 = self.chunks.iter().map(|chunk| chunk.bytes).sum();
        // The size in 64 bits follows the name.
        out.u32(1).bytes(b"mdat").u64(bytes + 16);
        out.0
    }

    fn sample_tables(&self, out: &mut Boxes, begin: u64) {
        let count = |length: usize| u32::try_from(length).unwrap_or(u32::MAX);
        out.full(b"stts", 0, 0, |out| {
            out.u32(1).u32(count(self.samples.len())).u32(self.frame_time);
        });
        let numbered = (1..).zip(&self.samples);
        let keys: Vec<u32> =
            numbered.filter(|(_, sample)| sample.is_key).map(|(number, _)| number).collect();
        out.full(b"stss", 0, 0, |out| {
            out.u32(count(keys.len()));
            keys.iter().for_each(|number| _ = out.u32(*number));
        });
        out.full(b"stsc", 0, 0, |out| {
            out.u32(count(self.chunks.len()));
            for (number, chunk) in (1..).zip(&self.chunks) {
                out.u32(number).u32(chunk.samples).u32(1);
            }
        });
        out.full(b"stsz", 0, 0, |out| {
            out.u32(0).u32(count(self.samples.len()));
            self.samples.iter().for_each(|sample| _ = out.u32(sample.bytes));
        });
        out.full(b"co64", 0, 0, |out| {
            out.u32(count(self.chunks.len()));
            let mut at = begin;
            for chunk in &self.chunks {
                out.u64(at);
                at += chunk.bytes;
            }
        });
    }

    fn movie_header(&self, out: &mut Boxes, duration: u64) {
        out.full(b"mvhd", 1, 0, |out| {
            // No times of creation, so that equal films have equal bytes. Then speed and volume 1.
            out.zeros(16).u32(self.timescale).u64(duration).u32(0x1_0000).u16(0x100).zeros(10);
            UNIT_MATRIX.iter().for_each(|number| _ = out.u32(*number));
            out.zeros(24).u32(TRACK_ID + 1);
        });
    }

    /// Appends the track with its tables of frames, which `tables` appends.
    fn track(
        &self,
        out: &mut Boxes,
        duration: u64,
        sets: [&[u8]; 2],
        tables: impl FnOnce(&mut Boxes),
    ) {
        out.boxed(b"trak", |out| {
            // Flags: enabled, in the movie, in the preview.
            out.full(b"tkhd", 1, 7, |out| {
                out.zeros(16).u32(TRACK_ID).u32(0).u64(duration).zeros(16);
                UNIT_MATRIX.iter().for_each(|number| _ = out.u32(*number));
                self.size.iter().for_each(|side| _ = out.u16(*side).u16(0));
            });
            out.boxed(b"mdia", |out| {
                out.full(b"mdhd", 1, 0, |out| {
                    // The language is undetermined.
                    out.zeros(16).u32(self.timescale).u64(duration).u16(0x55c4).u16(0);
                });
                out.full(b"hdlr", 0, 0, |out| {
                    out.u32(0).bytes(b"vide").zeros(12).bytes(b"Populace\0");
                });
                out.boxed(b"minf", |out| {
                    out.full(b"vmhd", 0, 1, |out| _ = out.zeros(8));
                    out.boxed(b"dinf", |out| {
                        // The frames are in this file.
                        out.full(b"dref", 0, 0, |out| {
                            out.u32(1);
                            out.full(b"url ", 0, 1, |_| {});
                        });
                    });
                    out.boxed(b"stbl", |out| {
                        out.full(b"stsd", 0, 0, |out| {
                            out.u32(1);
                            self.sample_entry(out, sets);
                        });
                        tables(out);
                    });
                });
            });
        });
    }

    fn sample_entry(&self, out: &mut Boxes, [sequence, picture]: [&[u8]; 2]) {
        out.boxed(b"avc1", |out| {
            out.zeros(6).u16(1).zeros(16);
            self.size.iter().for_each(|side| _ = out.u16(*side));
            // 72 pixels per inch, one frame per sample, no name, 24 bits per pixel.
            out.u32(0x48_0000).u32(0x48_0000).u32(0).u16(1).zeros(32).u16(24).u16(0xffff);
            out.boxed(b"avcC", |out| {
                let profile = |at: usize| sequence.get(at).copied().unwrap_or_default();
                out.u8(1).u8(profile(1)).u8(profile(2)).u8(profile(3));
                // Lengths have four bytes; one set of each kind.
                out.u8(0xff).u8(0xe1);
                out.u16(u16::try_from(sequence.len()).unwrap_or(u16::MAX)).bytes(sequence);
                out.u8(1).u16(u16::try_from(picture.len()).unwrap_or(u16::MAX)).bytes(picture);
                if profile(1) >= 100 {
                    // High profiles: colour at half size, 8 bits each, no further sets.
                    out.u8(0xfd).u8(0xf8).u8(0xf8).u8(0);
                }
            });
            // BT.709: primaries, transfer, matrix; limited range.
            out.boxed(b"colr", |out| _ = out.bytes(b"nclx").u16(1).u16(1).u16(1).u8(0));
        });
    }
}

fn file_type(out: &mut Boxes) {
    out.boxed(b"ftyp", |out| _ = out.bytes(b"isom").u32(0x200).bytes(b"isomiso6avc1mp41"));
}
