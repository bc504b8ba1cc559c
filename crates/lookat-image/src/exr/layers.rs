//! Layers of a file: channels whose names differ in the last word, as `albedo.R` and `albedo.G` do.
//!
//! A file may have several parts, each with channels and perhaps a name. That name may stand before the names
//! of its channels: `R` of the part `albedo` is `albedo.R` as well.

use std::collections::{HashMap, HashSet};

use ::exr::meta::header::Header;

use super::words;

/// The channels to read, of one part.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Choice {
    /// The index of the part.
    pub part: usize,
    /// The indices of the channels in the part, and their names in the picture. The names are distinct.
    pub channels: Vec<(usize, String)>,
}

/// The picture to read if no layer is named: the first part with plain R, G and B, or Y, with all its channels; or else the
/// only layer with such channels; or else the first part.
///
/// # Panics
///
/// If there is no part.
pub(crate) fn default(parts: &[Header]) -> Choice {
    let layers = layers(parts);
    if let Some(layer) = layers.iter().find(|layer| layer.is_plain()) {
        return whole(parts, layer.part);
    }
    let mut colored = layers.iter().filter(|layer| layer.color().is_some());
    match (colored.next(), colored.next()) {
        (Some(only), None) => only.choice(),
        _ => whole(parts, 0),
    }
}

/// The layer, part or channel with this name, if there is one.
pub(crate) fn find(parts: &[Header], name: &str) -> Option<Choice> {
    let layers = layers(parts);
    let layer =
        |name_index: usize| layers.iter().find(|layer| layer.names[name_index] == name).map(Layer::choice);
    let channel = |name_index: usize| {
        layers.iter().find_map(|layer| {
            let mut channels = layer.channels.iter();
            let (at, _) = channels.find(|(_, word)| join(&layer.names[name_index], word) == name)?;
            Some(Choice { part: layer.part, channels: vec![(*at, "Y".into())] })
        })
    };
    layer(0).or_else(|| layer(1)).or_else(|| channel(0)).or_else(|| channel(1))
}

/// The names that [`find`] takes: layers, and channels that belong to no layer with a picture.
pub(crate) fn names(parts: &[Header]) -> Vec<String> {
    let mut names = Vec::new();
    let mut taken = HashSet::new();
    // Of equal names in two parts, the second needs the name of its part.
    let mut take = |candidates: [String; 2]| {
        let name = candidates.into_iter().find(|name| !name.is_empty() && taken.insert(name.clone()));
        let found = name.is_some();
        names.extend(name);
        found
    };
    for layer in layers(parts) {
        if layer.picture().is_some() && take(layer.names.clone()) {
            continue;
        }
        // Plain color is the default.
        let plain = if layer.is_plain() { layer.color().unwrap_or_default() } else { Vec::new() };
        for (index, (_, word)) in layer.channels.iter().enumerate() {
            if !plain.iter().any(|(at, _)| *at == index) {
                take(layer.names.each_ref().map(|name| join(name, word)));
            }
        }
    }
    names
}

/// Channels of one part whose names differ in the last word.
struct Layer {
    part: usize,
    /// The names of the channels without their last words, which may be empty; then the same with the name of the part before
    /// it.
    names: [String; 2],
    /// The indices of the channels in the part, and the last words of their names.
    channels: Vec<(usize, String)>,
}

/// All channels of the file, each in one layer.
fn layers(parts: &[Header]) -> Vec<Layer> {
    let mut layers: Vec<Layer> = Vec::new();
    for (part, header) in parts.iter().enumerate() {
        let part_name = header.own_attributes.layer_name.as_ref().map(words).unwrap_or_default();
        let mut indices = HashMap::new();
        for (at, channel) in header.channels.list.iter().enumerate() {
            let whole = words(&channel.name);
            let (name, word) = whole.rsplit_once('.').unwrap_or(("", &whole));
            let index = *indices.entry(name.to_string()).or_insert_with(|| {
                let names = [name.into(), join(&part_name, name)];
                layers.push(Layer { part, names, channels: Vec::new() });
                layers.len() - 1
            });
            layers[index].channels.push((at, word.into()));
        }
    }
    layers
}

impl Layer {
    /// True if the channels are called R, G and B, or Y, without a layer name.
    fn is_plain(&self) -> bool {
        let has = |name: &str| self.channels.iter().any(|(_, word)| word == name);
        self.names[0].is_empty() && (has("R") && has("G") && has("B") || has("Y") && !has("X"))
    }

    /// The indices in `channels` of red, green and blue, or of gray, with their names in the picture.
    fn color(&self) -> Option<Vec<(usize, &'static str)>> {
        let gray = || match (self.index("y"), self.index("x")) {
            (Some(y), None) => Some(vec![(y, "Y")]),
            // With X, it is the middle of a vector.
            _ => None,
        };
        self.three(["r", "g", "b"]).or_else(|| self.three(["red", "green", "blue"])).or_else(gray)
    }

    /// The indices and names of [`Layer::color`], or else of a vector, or of the only channel.
    fn picture(&self) -> Option<Vec<(usize, &'static str)>> {
        let alone = || (self.channels.len() == 1).then(|| vec![(0, "Y")]);
        self.color().or_else(|| self.three(["x", "y", "z"])).or_else(alone)
    }

    fn three(&self, words: [&str; 3]) -> Option<Vec<(usize, &'static str)>> {
        words.into_iter().zip(["R", "G", "B"]).map(|(word, name)| Some((self.index(word)?, name))).collect()
    }

    fn index(&self, name: &str) -> Option<usize> {
        self.channels.iter().position(|(_, word)| word.eq_ignore_ascii_case(name))
    }

    /// All channels, under plain names.
    fn choice(&self) -> Choice {
        let picture = self.picture().unwrap_or_default();
        let colors = picture.iter().map(|(index, name)| (self.channels[*index].0, name.to_string()));
        let rest = self.channels.iter().filter(|(at, _)| colors.clone().all(|(color, _)| color != *at));
        Choice { part: self.part, channels: distinct(colors.clone().chain(rest.cloned())) }
    }
}

/// All channels of a part, under their own names.
fn whole(parts: &[Header], part: usize) -> Choice {
    let names = parts[part].channels.list.iter().map(|channel| words(&channel.name));
    Choice { part, channels: distinct(names.enumerate()) }
}

/// Drops channels whose names came before.
fn distinct(channels: impl Iterator<Item = (usize, String)>) -> Vec<(usize, String)> {
    let mut names = HashSet::new();
    channels.filter(|(_, name)| names.insert(name.clone())).collect()
}

/// Both names with a dot between, if there are two.
fn join(first: &str, second: &str) -> String {
    let dot = if first.is_empty() || second.is_empty() { "" } else { "." };
    format!("{first}{dot}{second}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use ::exr::meta::attribute::{ChannelDescription, SampleType};

    /// Parts, each a name and the names of its channels.
    fn parts(parts: &[(&str, &str)]) -> Vec<Header> {
        let part = |(name, channels): &(&str, &str)| {
            let channel = |name| ChannelDescription::named(name, SampleType::F32);
            Header::new((*name).into(), (1, 1), channels.split(' ').map(channel).collect())
        };
        parts.iter().map(part).collect()
    }

    /// The part, and the channels with their places.
    fn text(choice: &Choice) -> String {
        let channels = choice.channels.iter().map(|(at, name)| format!(" {name}={at}"));
        format!("{}:{}", choice.part, channels.collect::<String>())
    }

    #[test]
    fn color_is_found_without_a_choice() {
        let check =
            |list: &[(&str, &str)], expected: &str| assert_eq!(text(&default(&parts(list))), expected);
        check(&[("", "B G R Z albedo.R")], "0: B=0 G=1 R=2 Z=3 albedo.R=4");
        check(&[("depth", "Z"), ("beauty", "B G R"), ("more", "Y")], "1: B=0 G=1 R=2");
        check(&[("normal", "X Y Z"), ("beauty", "Y")], "1: Y=0");
        check(&[("", "c.A c.B c.G c.R d.Z n.X n.Y n.Z")], "0: R=3 G=2 B=1 A=0");
        check(&[("ids", "id"), ("light", "l.blue l.green l.red")], "1: R=2 G=1 B=0");
        check(&[("", "b g r")], "0: R=2 G=1 B=0");
        // Several, or none.
        check(&[("", "a.B a.G a.R b.Y")], "0: a.B=0 a.G=1 a.R=2 b.Y=3");
        check(&[("", "X Y Z"), ("", "n.X n.Y n.Z")], "0: X=0 Y=1 Z=2");
    }

    #[test]
    fn layers_parts_and_channels_have_names() {
        let list = parts(&[
            ("", "A a.A a.B a.G a.R a.b.Y n.X n.Y n.Z uv.U uv.V"),
            ("left", "Z b.b b.g b.r"),
            ("right", "Z b.R b.b b.g b.r"),
        ]);
        let expected = "A a a.b n uv.U uv.V left b right right.b";
        assert_eq!(names(&list).join(" "), expected);

        let check = |name: &str, expected: &str| {
            assert_eq!(find(&list, name).as_ref().map(text).unwrap_or_default(), expected, "{name}");
        };
        check("a", "0: R=4 G=3 B=2 A=1");
        check("a.b", "0: Y=5");
        check("n", "0: R=6 G=7 B=8");
        check("uv", "0: U=9 V=10");
        check("uv.V", "0: Y=10");
        check("A", "0: Y=0");
        check("left", "1: Y=0");
        check("b", "1: R=3 G=2 B=1");
        // `R` is preferred to `r`, which keeps its name.
        check("right.b", "2: R=1 G=3 B=2 r=4");
        check("Z", "1: Y=0");
        check("right.Z", "2: Y=0");
        check("right.b.r", "2: Y=4");
        check("c", "");
        check("a.R.", "");
    }

    #[test]
    fn plain_color_needs_no_choice() {
        assert_eq!(names(&parts(&[("", "A B G R")])), ["A"]);
        assert_eq!(names(&parts(&[("", "B G"), ("", "Z"), ("", "Z")])), ["B", "G", "Z"]);
    }
}
