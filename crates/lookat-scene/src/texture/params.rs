//! Parameters that may name textures.

use std::ops::{Deref, DerefMut};

use glam::Vec3;
use lookat_syntax::ParamType;

use super::Texture;
use crate::names::Names;
use crate::params::Params;
use crate::schema::{ColorTexture, DefaultValue, FloatTexture, GivenTexture, Key};
use crate::symbols::SymbolKind;

/// The textures in scope. An unsupported texture has no value, and parameters that name it keep their default.
pub(crate) struct Textures {
    pub float: Names<Option<Texture<f64>>>,
    pub spectrum: Names<Option<Texture<Vec3>>>,
}

impl Default for Textures {
    fn default() -> Self {
        Textures {
            float: Names::new(SymbolKind::FloatTexture),
            spectrum: Names::new(SymbolKind::SpectrumTexture),
        }
    }
}

/// Parameters with the textures in scope (pbrt-v3's TextureParams).
pub(crate) struct TextureParams<'t, 'p> {
    params: &'t mut Params<'p>,
    textures: &'t Textures,
}

impl<'t, 'p> TextureParams<'t, 'p> {
    pub fn new(params: &'t mut Params<'p>, textures: &'t Textures) -> Self {
        TextureParams { params, textures }
    }

    /// Takes a parameter that can name a texture.
    pub fn take_texture<T: TakeTexture>(&mut self, key: &Key<T>) -> T::Taken {
        T::take(key, self)
    }

    /// A color or a named texture.
    pub fn spectrum_texture(&mut self, name: &'static str, default: Vec3) -> Texture<Vec3> {
        let Some(texture) = self.texture(name) else {
            return Texture::Constant(self.spectrum(name, default));
        };
        self.ask(name, ParamType::Rgb);
        let Textures { float, spectrum } = self.textures;
        let known = self.params.find_texture(spectrum, float, &texture);
        known.cloned().flatten().unwrap_or(Texture::Constant(default))
    }

    /// A number or a named texture.
    pub fn float_texture(&mut self, name: &'static str, default: f64) -> Texture<f64> {
        self.float_texture_if_given(name).unwrap_or(Texture::Constant(default))
    }

    /// A number or a named texture, if the parameter is given and has a value.
    pub fn float_texture_if_given(&mut self, name: &'static str) -> Option<Texture<f64>> {
        let Some(texture) = self.texture(name) else {
            return self.float_if_given(name).map(Texture::Constant);
        };
        self.ask(name, ParamType::Float);
        let Textures { float, spectrum } = self.textures;
        let known = self.params.find_texture(float, spectrum, &texture);
        known.cloned().flatten()
    }
}

impl<'p> Deref for TextureParams<'_, 'p> {
    type Target = Params<'p>;

    fn deref(&self) -> &Params<'p> {
        self.params
    }
}

impl<'p> DerefMut for TextureParams<'_, 'p> {
    fn deref_mut(&mut self) -> &mut Params<'p> {
        self.params
    }
}

/// A type of value that can name a texture instead.
pub(crate) trait TakeTexture: DefaultValue {
    /// What the constructor gets.
    type Taken;

    fn take(key: &Key<Self>, params: &mut TextureParams) -> Self::Taken;
}

impl TakeTexture for FloatTexture {
    type Taken = Texture<f64>;

    fn take(key: &Key<Self>, params: &mut TextureParams) -> Texture<f64> {
        let texture = params.float_texture(key.name, key.default.0);
        match texture.constant() {
            Some(value) if !params.check_within(key, value) => Texture::Constant(key.default.0),
            _ => texture,
        }
    }
}

impl TakeTexture for GivenTexture {
    type Taken = Option<Texture<f64>>;

    fn take(key: &Key<Self>, params: &mut TextureParams) -> Option<Texture<f64>> {
        let texture = params.float_texture_if_given(key.name)?;
        let is_within = texture.constant().is_none_or(|value| params.check_within(key, value));
        is_within.then_some(texture)
    }
}

impl TakeTexture for ColorTexture {
    type Taken = Texture<Vec3>;

    fn take(key: &Key<Self>, params: &mut TextureParams) -> Texture<Vec3> {
        params.spectrum_texture(key.name, key.default.0)
    }
}
