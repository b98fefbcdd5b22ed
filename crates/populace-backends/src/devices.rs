//! Sets of devices that share a crowd, and their shares.

use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

use populace_device::{GlContext, Schedule};

use crate::device::{Device, Engine, Opened};
use crate::error::{DevicesFault, Error, SplitFault};
use crate::split::SplitBackend;

/// One device, or several that share a crowd: each evaluates some of its members at the same time.
///
/// Palettes are gathered on the first device, which shares buffers with OpenGL. Name the GPU that
/// draws them first.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Devices(Vec<Device>);

impl Devices {
    /// The devices, in the order in which they were named.
    #[must_use]
    pub fn as_slice(&self) -> &[Device] {
        &self.0
    }

    fn check(&self) -> Result<(), Error> {
        let refused = |fault| Err(Error::BadDevices { devices: self.to_string(), fault });
        if self.0.is_empty() {
            return refused(DevicesFault::None);
        }
        let twice =
            self.0.iter().enumerate().find(|(place, device)| self.0[..*place].contains(device));
        twice.map_or(Ok(()), |(_, device)| refused(DevicesFault::Twice(device.to_string())))
    }

    /// Opens the devices. The first shares buffers with the OpenGL context if one is given and its
    /// driver supports it.
    ///
    /// # Errors
    ///
    /// [`Error::BadDevices`], [`Error::BadSplit`], or a device that cannot be opened.
    pub fn open(
        &self,
        schedule: Schedule,
        split: &Split,
        gl: Option<&Arc<dyn GlContext>>,
    ) -> Result<Opened, Error> {
        self.check()?;
        let shares = split.shares(self)?;
        let mut opened = self.0[0].open(schedule, gl)?;
        if self.0.len() > 1 {
            let mut backends = vec![opened.engine.into_backend()];
            for device in &self.0[1..] {
                backends.push(device.open(schedule, None)?.engine.into_backend());
            }
            opened.engine = Engine::Split(Box::new(SplitBackend::new(backends, shares)));
        }
        Ok(opened)
    }
}

impl From<Device> for Devices {
    fn from(device: Device) -> Self {
        Self(vec![device])
    }
}

impl From<&[Device]> for Devices {
    fn from(devices: &[Device]) -> Self {
        Self(devices.to_vec())
    }
}

impl<const N: usize> From<&[Device; N]> for Devices {
    fn from(devices: &[Device; N]) -> Self {
        Self(devices.to_vec())
    }
}

impl<const N: usize> From<[Device; N]> for Devices {
    fn from(devices: [Device; N]) -> Self {
        Self(devices.to_vec())
    }
}

impl From<Vec<Device>> for Devices {
    fn from(devices: Vec<Device>) -> Self {
        Self(devices)
    }
}

impl fmt::Display for Devices {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (place, device) in self.0.iter().enumerate() {
            write!(f, "{}{device}", if place > 0 { "+" } else { "" })?;
        }
        Ok(())
    }
}

impl FromStr for Devices {
    type Err = Error;

    /// Parses names of devices joined by `+`.
    fn from_str(names: &str) -> Result<Self, Error> {
        let devices = Self(names.split('+').map(str::parse).collect::<Result<_, _>>()?);
        devices.check().map(|()| devices)
    }
}

/// The shares of several devices. They do not affect results, except where devices differ: native
/// and PoCL compute the same bits.
#[non_exhaustive]
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Split {
    /// By measured speed, so that all devices take equally long.
    #[default]
    Measured,
    /// A number of parts for each device: 60 and 40 mean the same as 3 and 2. A device with 0 does
    /// nothing.
    Fixed(Vec<f64>),
}

impl Split {
    /// Returns a share for each device, whose sum is 1; `None` if they are measured.
    ///
    /// # Errors
    ///
    /// [`Error::BadSplit`] for a split that does not fit the devices.
    pub fn shares(&self, devices: &Devices) -> Result<Option<Vec<f64>>, Error> {
        let (Self::Fixed(parts), count) = (self, devices.0.len()) else { return Ok(None) };
        let refused = |fault| Err(Error::BadSplit(fault));
        if parts.len() != count {
            let (shares, devices) = (parts.len(), devices.to_string());
            return refused(SplitFault::Count { shares, count, devices });
        }
        let total: f64 = parts.iter().sum();
        match parts.iter().find(|part| !part.is_finite() || **part < 0.0) {
            Some(part) => refused(SplitFault::Share(*part)),
            None if !total.is_finite() => refused(SplitFault::TooLarge),
            None if total <= 0.0 => refused(SplitFault::AllZero),
            None => Ok(Some(parts.iter().map(|part| part / total).collect())),
        }
    }
}

impl fmt::Display for Split {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self::Fixed(parts) = self else { return f.write_str("measured") };
        for (place, part) in parts.iter().enumerate() {
            write!(f, "{}{part}", if place > 0 { "," } else { "" })?;
        }
        Ok(())
    }
}

impl FromStr for Split {
    type Err = Error;

    /// Parses `measured`, or shares as in `60,40`.
    fn from_str(text: &str) -> Result<Self, Error> {
        if text == "measured" {
            return Ok(Self::Measured);
        }
        let parts: Result<Vec<f64>, _> = text.split(',').map(|part| part.trim().parse()).collect();
        let no_shares = |_| Error::BadSplit(SplitFault::Text(text.to_owned()));
        parts.map(Self::Fixed).map_err(no_shares)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn device_lists_parse_and_bad_lists_are_refused() {
        let three = Devices::from([
            Device::Native { threads: 1 },
            Device::opencl(0),
            Device::opencl_part(1, 1, 2),
        ]);
        assert_eq!(three.to_string(), "native:1+opencl:0+opencl:1:1/2");
        assert_eq!("native:1+opencl+opencl:1:1/2".parse(), Ok(three));
        assert_eq!("native".parse(), Ok(Devices::from(Device::native())));
        for (names, reason) in [
            ("native+native", "native+native: native is named twice"),
            ("opencl+native+opencl:0", "opencl:0 is named twice"),
            ("native+", "there is no device \"\""),
            ("native+cuda", "there is no device \"cuda\""),
        ] {
            let error = names.parse::<Devices>().unwrap_err().to_string();
            assert!(error.contains(reason), "{error}");
        }
        let error = Devices::from([]).check().unwrap_err();
        assert!(error.to_string().contains("name at least one"), "{error}");
    }

    #[test]
    fn shares_are_normalized_and_bad_shares_are_refused() {
        let two = Devices::from([Device::native(), Device::opencl(0)]);
        let shares = |text: &str| text.parse::<Split>().and_then(|split| split.shares(&two));
        assert_eq!(shares("measured"), Ok(None));
        assert_eq!(shares("60,40"), Ok(Some(vec![0.6, 0.4])));
        assert_eq!(shares(" 3 , 1 "), Ok(Some(vec![0.75, 0.25])));
        assert_eq!(shares("0,100"), Ok(Some(vec![0.0, 1.0])));
        assert_eq!(Split::Fixed(vec![60.0, 2.5]).to_string(), "60,2.5");
        assert_eq!(Split::Measured.to_string().parse(), Ok(Split::Measured));
        for (text, reason) in [
            ("", "is not a list of numbers"),
            ("half", "as in 60,40"),
            ("60;40", "is not a list of numbers"),
            ("60,", "is not a list of numbers"),
            ("60", "has one share for 2 devices, native+opencl:0; give each device one"),
            ("1,1,1", "has 3 shares for 2 devices"),
            ("60,-40", "has a share of -40"),
            ("NaN,1", "has a share of NaN"),
            ("inf,1", "has a share of inf"),
            ("1e308,1e308", "too large"),
            ("0,0", "no share above 0"),
        ] {
            let error = shares(text).unwrap_err().to_string();
            assert!(error.starts_with("the split ") && error.contains(reason), "{text}: {error}");
        }
    }
}
