//! The few things that were used last, by key: what was not used for longest makes room for what is new.

/// At most so many values, the one used last at the end.
#[derive(Debug)]
pub(super) struct Recent<K, V> {
    entries: Vec<(K, V)>,
    most: usize,
}

impl<K, V> Recent<K, V> {
    /// Nothing yet; at least one value can be held.
    pub(super) fn new(most: usize) -> Self {
        Self { entries: Vec::new(), most: most.max(1) }
    }

    /// Whether the next new value makes another one leave.
    pub(super) fn is_full(&self) -> bool {
        self.entries.len() >= self.most
    }

    /// Makes the value whose key is meant the one used last; answers whether it is there.
    pub(super) fn touch(&mut self, is_meant: impl Fn(&K) -> bool) -> bool {
        let found = self.entries.iter().position(|(key, _)| is_meant(key));
        if let Some(at) = found {
            self.entries[at..].rotate_left(1);
        }
        found.is_some()
    }

    /// Adds a value as the one used last.
    pub(super) fn insert(&mut self, key: K, value: V) {
        if self.is_full() {
            self.entries.remove(0);
        }
        self.entries.push((key, value));
    }

    /// The value whose key is meant.
    pub(super) fn get(&self, is_meant: impl Fn(&K) -> bool) -> Option<&V> {
        self.entries.iter().find(|(key, _)| is_meant(key)).map(|(_, value)| value)
    }

    /// The value used last.
    pub(super) fn newest_mut(&mut self) -> Option<&mut V> {
        self.entries.last_mut().map(|(_, value)| value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_not_used_for_longest_leaves() {
        let mut recent = Recent::new(2);
        recent.insert('a', 1);
        recent.insert('b', 2);
        assert!(recent.is_full() && recent.touch(|key| *key == 'a'));
        assert_eq!(recent.newest_mut(), Some(&mut 1));
        recent.insert('c', 3);
        assert_eq!(recent.get(|key| *key == 'b'), None);
        assert_eq!((recent.get(|key| *key == 'a'), recent.get(|key| *key == 'c')), (Some(&1), Some(&3)));
        assert!(!recent.touch(|key| *key == 'b'));
        assert_eq!(recent.newest_mut(), Some(&mut 3));
    }
}
