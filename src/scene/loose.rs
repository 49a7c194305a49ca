//! Values of the scene file that may take several forms: a number, a list, a text or a table.

use std::fmt;

use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{Error as _, IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

use super::file::{DivisionDef, FovDef, ModeDef, ModeName, PanesDef, SpectrumDef, ValueDef};

/// A value that may be a number, a list or a text: collects what its type accepts.
struct Loose {
    number: bool,
    list: bool,
    text: bool,
    map: bool,
    expected: &'static str,
}

/// What was found.
enum Found<M> {
    Number(f64),
    List(Vec<f64>),
    Text(String),
    Map(M),
}

struct LooseVisitor<M> {
    what: Loose,
    marker: std::marker::PhantomData<M>,
}

impl<'de, M: Deserialize<'de>> Visitor<'de> for LooseVisitor<M> {
    type Value = Found<M>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.what.expected)
    }
    fn visit_i64<E: serde::de::Error>(self, v: i64) -> Result<Self::Value, E> {
        self.visit_f64(v as f64)
    }
    fn visit_u64<E: serde::de::Error>(self, v: u64) -> Result<Self::Value, E> {
        self.visit_f64(v as f64)
    }
    fn visit_f64<E: serde::de::Error>(self, v: f64) -> Result<Self::Value, E> {
        if self.what.number {
            return Ok(Found::Number(v));
        }
        Err(E::invalid_type(serde::de::Unexpected::Float(v), &self))
    }
    fn visit_str<E: serde::de::Error>(self, v: &str) -> Result<Self::Value, E> {
        if self.what.text {
            return Ok(Found::Text(v.to_owned()));
        }
        Err(E::invalid_type(serde::de::Unexpected::Str(v), &self))
    }
    fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<Self::Value, A::Error> {
        if self.what.list {
            return Vec::deserialize(SeqAccessDeserializer::new(seq)).map(Found::List);
        }
        Err(A::Error::invalid_type(serde::de::Unexpected::Seq, &self))
    }
    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Self::Value, A::Error> {
        if self.what.map {
            return M::deserialize(MapAccessDeserializer::new(map)).map(Found::Map);
        }
        Err(A::Error::invalid_type(serde::de::Unexpected::Map, &self))
    }
}

impl Loose {
    fn read<'de, M: Deserialize<'de>, D: Deserializer<'de>>(self, d: D) -> Result<Found<M>, D::Error> {
        d.deserialize_any(LooseVisitor { what: self, marker: std::marker::PhantomData })
    }
}

impl<'de> Deserialize<'de> for ModeDef {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        let expected = "a name or a table with `step_nm` and `range_nm`, or `edges_nm`";
        let what = Loose { number: false, list: false, text: true, map: true, expected };
        match what.read::<DivisionDef, D>(d)? {
            Found::Map(division) => Ok(Self::Division(division)),
            Found::Text(name) => {
                let name: serde::de::value::StringDeserializer<D::Error> =
                    serde::de::IntoDeserializer::into_deserializer(name);
                ModeName::deserialize(name).map(Self::Name)
            }
            Found::Number(_) | Found::List(_) => Err(D::Error::custom(expected)),
        }
    }
}

impl<'de> Deserialize<'de> for ValueDef {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        let expected = "a number, [r, g, b] or the name of a spectrum file";
        let what = Loose { number: true, list: true, text: true, map: false, expected };
        match what.read::<IgnoredAny, D>(d)? {
            Found::Number(v) => Ok(Self::Number(v)),
            Found::Text(name) => Ok(Self::File(name)),
            Found::List(v) => exactly(&v, "[r, g, b]").map(Self::Rgb),
            Found::Map(_) => Err(D::Error::custom(expected)),
        }
    }
}

impl<'de> Deserialize<'de> for PanesDef {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        struct PanesVisitor;
        impl<'de> Visitor<'de> for PanesVisitor {
            type Value = PanesDef;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number of panes or a list of tables with `transmittance`")
            }
            fn visit_i64<E: serde::de::Error>(self, v: i64) -> Result<PanesDef, E> {
                u32::try_from(v)
                    .map(PanesDef::Count)
                    .map_err(|_| E::invalid_value(serde::de::Unexpected::Signed(v), &self))
            }
            fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<PanesDef, A::Error> {
                Vec::deserialize(SeqAccessDeserializer::new(seq)).map(PanesDef::List)
            }
        }
        d.deserialize_any(PanesVisitor)
    }
}

impl<'de> Deserialize<'de> for SpectrumDef {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        let expected = "an illuminant name, a colour temperature in K or the name of a spectrum file";
        let what = Loose { number: true, list: false, text: true, map: false, expected };
        match what.read::<IgnoredAny, D>(d)? {
            Found::Number(v) => Ok(Self::Kelvin(v)),
            Found::Text(name) => Ok(Self::Name(name)),
            Found::List(_) | Found::Map(_) => Err(D::Error::custom(expected)),
        }
    }
}

impl<'de> Deserialize<'de> for FovDef {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        let expected = "an angle in degrees or [horizontal, vertical]";
        let what = Loose { number: true, list: true, text: false, map: false, expected };
        match what.read::<IgnoredAny, D>(d)? {
            Found::Number(v) => Ok(Self::Horizontal(v)),
            Found::List(v) => exactly(&v, "[horizontal, vertical]").map(Self::Both),
            Found::Text(_) | Found::Map(_) => Err(D::Error::custom(expected)),
        }
    }
}

/// A list of exactly `N` numbers.
fn exactly<const N: usize, E: serde::de::Error>(list: &[f64], what: &str) -> Result<[f64; N], E> {
    list.try_into().map_err(|_| E::custom(format!("expected {N} numbers {what}, found {}", list.len())))
}
