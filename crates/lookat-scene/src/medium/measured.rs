//! Measured media, by name.
//!
//! Their coefficients are those of pbrt-v3 (core/medium.cpp), per millimeter:
//!
//! - The first twelve: Jensen, Marschner, Levoy, Hanrahan, "A Practical Model for Subsurface Light Transport", SIGGRAPH 2001
//! - The others: Narasimhan et al., "Acquiring Scattering Properties of Participating Media by Dilution", SIGGRAPH 2006

use std::sync::LazyLock;

use glam::Vec3;
use lookat_syntax::{Diagnostic, ParamType, Text, nearest};

use crate::params::Params;
use crate::params::value::{Name, ParamValue};
use crate::schema::{Key, Range};

/// A measured medium.
pub(crate) struct MeasuredMedium {
    /// Its name in scenes.
    name: &'static str,
    /// Reduced scattering coefficient (red, green, blue), per millimeter.
    pub scattering: Vec3,
    /// Absorption coefficient (red, green, blue), per millimeter.
    pub absorption: Vec3,
}

static MEDIA: LazyLock<Vec<MeasuredMedium>> = LazyLock::new(|| {
    let medium = |line: &'static str| {
        let (name, numbers) = line.split_once(": ")?;
        let numbers: Vec<f32> = numbers.split(' ').filter_map(|number| number.parse().ok()).collect();
        let [scattering, absorption] = [0, 3].map(|at| Vec3::from_slice(&numbers[at..]));
        Some(MeasuredMedium { name, scattering, absorption })
    };
    include_str!("measured.txt").lines().filter_map(medium).collect()
});

impl MeasuredMedium {
    /// The medium of a name.
    #[cfg(test)]
    pub fn named(name: &str) -> Option<&'static MeasuredMedium> {
        MEDIA.iter().find(|medium| medium.name == name)
    }

    /// The medium that a parameter names. Warns of a name that no medium has.
    pub fn take(params: &mut Params, key: &Key<MediumName>) -> Option<&'static MeasuredMedium> {
        let name = params.take(key).filter(|name| !name.value.is_empty())?;
        let medium = MEDIA.iter().find(|medium| medium.name == name.value);
        if medium.is_none() {
            let message =
                "there is no measured medium of this name: the default coefficients are used, as in pbrt-v3";
            let warning = Diagnostic::warning(name.span, message);
            params.push(match nearest(&name.value, MEDIA.iter().map(|medium| medium.name)) {
                Some(near) => {
                    warning.help(format!("did you mean \"{near}\"?")).fix(name.span, format!("\"{near}\""))
                }
                None => {
                    warning.help("docs/supported.md lists the names; sigma_a and sigma_s give other media")
                }
            });
        }
        medium
    }
}

/// The name of a measured medium, if given.
#[derive(Clone, Copy)]
pub(crate) struct MediumName;

impl ParamValue for MediumName {
    type Taken = Option<Text>;

    fn range(self, _: Range) -> String {
        format!("one of {}", MEDIA.iter().map(|medium| medium.name).collect::<Vec<_>>().join(", "))
    }

    fn take(key: &Key<MediumName>, params: &mut Params) -> Option<Text> {
        params.take(&key.of(Name))
    }
}

/// A parameter that names a measured medium.
pub(crate) const fn measured(name: &'static str, meaning: &'static str) -> Key<MediumName> {
    Key::new(name, ParamType::String, MediumName, meaning)
}
