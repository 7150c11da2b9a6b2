//! A map that keeps the order of the file.
//!
//! Records hold maps as lists of (key, value). The order must survive (it is written back, and some of it means something), lookups must
//! not walk hundreds of entries, and of two entries with one key the first counts (`spec/11-dat-files.md, 12.3`).

use serde::{Serialize, Serializer};

use super::error::Problem;
use super::reader::{Read, Reader};

/// Below this length a walk beats a search.
const WALK: usize = 8;

/// Entries in file order, found by key.
#[derive(Debug, Clone)]
pub struct KeyedList<K, V> {
    entries: Vec<(K, V)>,
    /// Entry numbers in order of key, then of position; empty while the list is short enough to walk or is in order already.
    order: Vec<u32>,
    sorted: bool,
}

impl<K, V> Default for KeyedList<K, V> {
    fn default() -> Self {
        Self {
            entries: Vec::new(),
            order: Vec::new(),
            sorted: true,
        }
    }
}

impl<K: PartialEq, V: PartialEq> PartialEq for KeyedList<K, V> {
    fn eq(&self, other: &Self) -> bool {
        self.entries == other.entries
    }
}

impl<K: Ord + Copy, V> KeyedList<K, V> {
    /// Takes entries in file order.
    #[must_use]
    pub fn new(entries: Vec<(K, V)>) -> Self {
        let sorted = entries.is_sorted_by(|a, b| a.0 <= b.0);
        let mut order = Vec::new();
        if !sorted && entries.len() > WALK {
            order = (0..entries.len() as u32).collect();
            order.sort_by_key(|&i| entries[i as usize].0);
        }
        Self {
            entries,
            order,
            sorted,
        }
    }

    /// Adds an entry at the end. Meant for building small maps: every call sorts anew.
    pub fn push(&mut self, key: K, value: V) {
        let mut entries = std::mem::take(&mut self.entries);
        entries.push((key, value));
        *self = Self::new(entries);
    }

    /// The value of the first entry with this key, to change it.
    pub fn get_mut(&mut self, key: K) -> Option<&mut V> {
        self.position(key).map(|i| &mut self.entries[i].1)
    }

    /// The value of the first entry with this key.
    #[must_use]
    pub fn get(&self, key: K) -> Option<&V> {
        self.position(key).map(|i| &self.entries[i].1)
    }

    /// The position in the file of the first entry with this key.
    #[must_use]
    pub fn position(&self, key: K) -> Option<usize> {
        let e = &self.entries;
        if e.len() <= WALK {
            return e.iter().position(|x| x.0 == key);
        }
        if self.sorted {
            let i = e.partition_point(|x| x.0 < key);
            return (i < e.len() && e[i].0 == key).then_some(i);
        }
        let i = self.order.partition_point(|&i| e[i as usize].0 < key);
        let at = *self.order.get(i)? as usize;
        (e[at].0 == key).then_some(at)
    }

    /// The first key that occurs twice.
    #[must_use]
    pub fn duplicate(&self) -> Option<K> {
        if self.sorted {
            return self
                .entries
                .windows(2)
                .find(|w| w[0].0 == w[1].0)
                .map(|w| w[0].0);
        }
        let mut keys: Vec<K> = self.entries.iter().map(|e| e.0).collect();
        keys.sort_unstable();
        keys.windows(2).find(|w| w[0] == w[1]).map(|w| w[0])
    }
}

impl<K, V> KeyedList<K, V> {
    /// Entries in file order.
    #[must_use]
    pub fn entries(&self) -> &[(K, V)] {
        &self.entries
    }

    /// Entries in file order.
    pub fn iter(&self) -> std::slice::Iter<'_, (K, V)> {
        self.entries.iter()
    }

    /// Number of entries.
    #[must_use]
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// True without entries.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }
}

impl<'a, K, V> IntoIterator for &'a KeyedList<K, V> {
    type Item = &'a (K, V);
    type IntoIter = std::slice::Iter<'a, (K, V)>;

    fn into_iter(self) -> Self::IntoIter {
        self.entries.iter()
    }
}

impl<K: Ord + Copy, V> FromIterator<(K, V)> for KeyedList<K, V> {
    fn from_iter<T: IntoIterator<Item = (K, V)>>(iter: T) -> Self {
        Self::new(iter.into_iter().collect())
    }
}

impl<K: Serialize, V: Serialize> Serialize for KeyedList<K, V> {
    fn serialize<S: Serializer>(&self, s: S) -> Result<S::Ok, S::Error> {
        s.collect_seq(&self.entries)
    }
}

/// Makes a list of entries into a map; a double key is a deviation.
pub(super) fn keyed<K: Ord + Copy + Into<i64>, V>(
    r: &mut Reader<'_>,
    what: &'static str,
    entries: Vec<(K, V)>,
) -> Read<KeyedList<K, V>> {
    let list = KeyedList::new(entries);
    if let Some(key) = list.duplicate() {
        let key: i64 = key.into();
        r.deviation(
            0,
            Problem::DuplicateKey {
                what,
                key: key as u32,
            },
        )?;
    }
    Ok(list)
}
