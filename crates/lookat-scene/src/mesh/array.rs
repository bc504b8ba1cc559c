//! Arrays of meshes: own ones, or memory that belongs to somebody else.

use std::fmt;
use std::ops::Deref;
use std::sync::Arc;

use yoke::Yoke;

/// The values of an array of a mesh. It reads as a slice.
#[derive(Clone)]
pub struct MeshArray<T: 'static>(Memory<T>);

#[derive(Clone)]
enum Memory<T: 'static> {
    Own(Vec<T>),
    Shared(Yoke<&'static [T], Arc<dyn AsRef<[T]> + Send + Sync>>),
}

impl<T> MeshArray<T> {
    /// The values of an owner, without a copy. The owner gives the same slice each time, whose values never change.
    pub fn shared(owner: Arc<dyn AsRef<[T]> + Send + Sync>) -> MeshArray<T> {
        MeshArray(Memory::Shared(Yoke::attach_to_cart(owner, |owner| owner.as_ref())))
    }

    /// The values, to change them. Shared values are copied first.
    pub(crate) fn to_mut(&mut self) -> &mut Vec<T>
    where
        T: Clone,
    {
        if let Memory::Shared(values) = &self.0 {
            self.0 = Memory::Own(values.get().to_vec());
        }
        match &mut self.0 {
            Memory::Own(values) => values,
            Memory::Shared(_) => unreachable!("it has just been copied"),
        }
    }
}

impl<T> From<Vec<T>> for MeshArray<T> {
    fn from(values: Vec<T>) -> MeshArray<T> {
        MeshArray(Memory::Own(values))
    }
}

impl<T> FromIterator<T> for MeshArray<T> {
    fn from_iter<I: IntoIterator<Item = T>>(values: I) -> MeshArray<T> {
        Vec::from_iter(values).into()
    }
}

impl<T> Default for MeshArray<T> {
    fn default() -> MeshArray<T> {
        Vec::new().into()
    }
}

impl<T> Deref for MeshArray<T> {
    type Target = [T];

    #[inline(always)]
    fn deref(&self) -> &[T] {
        match &self.0 {
            Memory::Own(values) => values,
            Memory::Shared(values) => values.get(),
        }
    }
}

impl<T: PartialEq> PartialEq for MeshArray<T> {
    fn eq(&self, other: &MeshArray<T>) -> bool {
        **self == **other
    }
}

impl<T: fmt::Debug> fmt::Debug for MeshArray<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        (**self).fmt(f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shared_values_are_not_copied_until_they_change() {
        let owner = Arc::new(vec![1, 2, 3]);
        let mut array = MeshArray::shared(owner.clone());
        assert_eq!(array.as_ptr(), owner.as_ptr());
        assert_eq!(array, MeshArray::from(vec![1, 2, 3]));
        let other = array.clone();
        array.to_mut().push(4);
        assert_eq!((&array[..], &other[..]), (&[1, 2, 3, 4][..], &owner[..]));
        drop((array, other));
        assert_eq!(Arc::strong_count(&owner), 1);
    }
}
