//! Components of values, saved and read back.
//!
//! Serde knows arrays of up to 32 numbers; values have as many as they like, and
//! a bound on the trait would be one on every user's.

use core::fmt;
use core::marker::PhantomData;

use serde::de::{Error, SeqAccess, Visitor};
use serde::ser::SerializeTuple;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::value::{Components, Value};

/// Components by themselves: where a field's type has them inside another.
#[derive(Clone, Copy)]
pub(crate) struct Flat<C>(pub(crate) C);

impl<C: Components> Serialize for Flat<C> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        write(self.0.as_ref(), to, |x| *x)
    }
}

impl<'de, C: Components> Deserialize<'de> for Flat<C> {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let mut components = C::ZERO;
        read(from, components.as_mut(), |x: f64| x)?;
        Ok(Self(components))
    }
}

/// A field of components.
pub(crate) mod components {
    use super::*;

    pub(crate) fn serialize<C: Components, S: Serializer>(c: &C, to: S) -> Result<S::Ok, S::Error> {
        Flat(*c).serialize(to)
    }

    pub(crate) fn deserialize<'de, C: Components, D: Deserializer<'de>>(
        from: D,
    ) -> Result<C, D::Error> {
        Flat::deserialize(from).map(|flat| flat.0)
    }
}

/// A field of components that may not be there.
pub(crate) mod maybe {
    use super::*;

    pub(crate) fn serialize<C: Components, S: Serializer>(
        c: &Option<C>,
        to: S,
    ) -> Result<S::Ok, S::Error> {
        c.map(Flat).serialize(to)
    }

    pub(crate) fn deserialize<'de, C: Components, D: Deserializer<'de>>(
        from: D,
    ) -> Result<Option<C>, D::Error> {
        Ok(Option::<Flat<C>>::deserialize(from)?.map(|flat| flat.0))
    }
}

/// A field that is a value in double precision.
pub(crate) mod wide {
    use super::*;

    pub(crate) fn serialize<W: Value, S: Serializer>(w: &W, to: S) -> Result<S::Ok, S::Error> {
        Flat(w.components()).serialize(to)
    }

    pub(crate) fn deserialize<'de, W: Value<Wide = W>, D: Deserializer<'de>>(
        from: D,
    ) -> Result<W, D::Error> {
        Flat::deserialize(from).map(|flat| W::wide(flat.0))
    }
}

/// A field with components in each of several rows.
pub(crate) mod rows {
    use super::*;

    pub(crate) fn serialize<C: Components, S: Serializer, const K: usize>(
        rows: &[C; K],
        to: S,
    ) -> Result<S::Ok, S::Error> {
        write(rows, to, |row| Flat(*row))
    }

    pub(crate) fn deserialize<'de, C: Components, D: Deserializer<'de>, const K: usize>(
        from: D,
    ) -> Result<[C; K], D::Error> {
        let mut rows = [C::ZERO; K];
        read(from, &mut rows, |flat: Flat<C>| flat.0)?;
        Ok(rows)
    }
}

/// A field with several things that can be saved.
pub(crate) mod each {
    use super::*;

    pub(crate) fn serialize<T: Serialize, S: Serializer, const K: usize>(
        items: &[T; K],
        to: S,
    ) -> Result<S::Ok, S::Error> {
        items.as_slice().serialize(to)
    }

    pub(crate) fn deserialize<'de, T: Deserialize<'de>, D: Deserializer<'de>, const K: usize>(
        from: D,
    ) -> Result<[T; K], D::Error> {
        let items = Vec::deserialize(from)?;
        let found = items.len();
        let as_many = |_| Error::invalid_length(found, &"another number");
        items.try_into().map_err(as_many)
    }
}

/// A field that is a matrix over components C.
pub(crate) struct Matrix<C>(PhantomData<C>);

impl<C: Components> Matrix<C> {
    pub(crate) fn serialize<S: Serializer>(m: &C::Matrix, to: S) -> Result<S::Ok, S::Error> {
        write(m.as_ref(), to, |row| Flat(*row))
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<C::Matrix, D::Error> {
        let mut matrix = C::ZERO_MATRIX;
        read(from, matrix.as_mut(), |flat: Flat<C>| flat.0)?;
        Ok(matrix)
    }
}

fn write<T, W: Serialize, S: Serializer>(
    items: &[T],
    to: S,
    wrap: impl Fn(&T) -> W,
) -> Result<S::Ok, S::Error> {
    let mut tuple = to.serialize_tuple(items.len())?;
    for item in items {
        tuple.serialize_element(&wrap(item))?;
    }
    tuple.end()
}

fn read<'de, T, W: Deserialize<'de>, D: Deserializer<'de>>(
    from: D,
    items: &mut [T],
    unwrap: fn(W) -> T,
) -> Result<(), D::Error> {
    from.deserialize_tuple(items.len(), Fill { items, unwrap })
}

struct Fill<'a, T, W> {
    items: &'a mut [T],
    unwrap: fn(W) -> T,
}

impl<'de, T, W: Deserialize<'de>> Visitor<'de> for Fill<'_, T, W> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} elements", self.items.len())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<(), A::Error> {
        for (index, item) in self.items.iter_mut().enumerate() {
            let element = seq.next_element()?;
            *item = (self.unwrap)(element.ok_or_else(|| A::Error::invalid_length(index, &"more"))?);
        }
        Ok(())
    }
}
