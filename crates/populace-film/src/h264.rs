//! H.264 by OpenH264.

use openh264::OpenH264API;
use openh264::encoder::{
    self, EncoderConfig, FrameType, IntraFramePeriod, Profile, QpRange, RateControlMode, VuiConfig,
};
use openh264::formats::YUVSlices;

use crate::Error;
use crate::mp4::FrameEncoder;
use crate::settings::FilmSettings;
use crate::yuv::Yuv;

/// The largest sides that OpenH264 encodes, the larger one first.
const LARGEST: [u32; 2] = [3840, 2160];
/// The smallest side that it encodes.
const SMALLEST: u32 = 16;
/// The kinds of units that hold parameter sets.
const SEQUENCE_SET: u8 = 7;
const PICTURE_SET: u8 = 8;

/// The built-in encoder.
pub(crate) struct OpenH264 {
    encoder: encoder::Encoder,
    yuv: Yuv,
    sets: [Vec<u8>; 2],
}

impl OpenH264 {
    pub(crate) fn new(settings: &FilmSettings) -> Result<Self, Error> {
        let [width, height] = settings.size;
        let [long, short] = [width.max(height), width.min(height)];
        if long > LARGEST[0] || short > LARGEST[1] || short < SMALLEST {
            return Err(Error::BadValue {
                what: "the size of the film",
                value: format!("{width}x{height}"),
                rule: "from 16x16 to 3840x2160 or 2160x3840; the encoder ffmpeg writes others",
            });
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "from 1 to 300, clamped here"
        )]
        let key_every = settings.rate.per_sec().round().clamp(1.0, 300.0) as u32;
        let quantizer = settings.quantizer;
        let config = EncoderConfig::new()
            // With equal bounds, this mode gives every frame the same quantizer. The mode `Quality`
            // drops frames or prints a warning, and `Off` ignores the bounds.
            .rate_control_mode(RateControlMode::Bufferbased)
            .qp(QpRange::new(quantizer, quantizer))
            .skip_frames(false)
            // Either would change the quantizer, or the distance of key frames.
            .adaptive_quantization(false)
            .scene_change_detect(false)
            .profile(Profile::High)
            .intra_frame_period(IntraFramePeriod::from_num_frames(key_every))
            .vui(VuiConfig::bt709())
            // More threads would give other bytes.
            .num_threads(1);
        let encoder = encoder::Encoder::with_api_config(OpenH264API::from_source(), config);
        let encoder = encoder.map_err(|error| failed(&error))?;
        Ok(Self { encoder, yuv: Yuv::new(settings.size), sets: Default::default() })
    }
}

fn failed(error: &openh264::Error) -> Error {
    Error::Encoder { encoder: "openh264", cause: error.to_string() }
}

impl FrameEncoder for OpenH264 {
    fn encode(&mut self, rgba: &[u8], bytes: &mut Vec<u8>) -> Result<bool, Error> {
        self.yuv.read(rgba);
        let ([width, height], [y, u, v]) = (self.yuv.size(), self.yuv.planes());
        let strides = (width, width / 2, width / 2);
        let source = YUVSlices::new((y, u, v), (width, height), strides);
        let stream = self.encoder.encode(&source).map_err(|error| failed(&error))?;
        let layers = (0..stream.num_layers()).filter_map(|number| stream.layer(number));
        for layer in layers {
            for unit in (0..layer.nal_count()).filter_map(|number| layer.nal_unit(number)) {
                let unit = without_start_code(unit);
                match unit.first().map(|kind| kind & 0x1f) {
                    Some(SEQUENCE_SET) => self.sets[0] = unit.to_vec(),
                    Some(PICTURE_SET) => self.sets[1] = unit.to_vec(),
                    _ => {
                        let length = u32::try_from(unit.len()).unwrap_or(u32::MAX);
                        bytes.extend(length.to_be_bytes());
                        bytes.extend(unit);
                    }
                }
            }
        }
        if bytes.is_empty() {
            let cause = format!("no frame came out ({:?})", stream.frame_type());
            return Err(Error::Encoder { encoder: "openh264", cause });
        }
        Ok(stream.frame_type() == FrameType::IDR)
    }

    fn parameter_sets(&self) -> [&[u8]; 2] {
        [&self.sets[0], &self.sets[1]]
    }
}

/// Returns a unit without the zeros and the one before it.
fn without_start_code(unit: &[u8]) -> &[u8] {
    let zeros = unit.iter().take_while(|byte| **byte == 0).count();
    unit.get(zeros + 1..).unwrap_or_default()
}
