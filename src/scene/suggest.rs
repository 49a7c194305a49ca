//! "Did you mean": the nearest valid name.

/// The candidate most like `name`, if any is near enough to be meant.
pub(crate) fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let name = name.to_lowercase();
    candidates
        .into_iter()
        .map(|c| (strsim::damerau_levenshtein(&name, &c.to_lowercase()), c))
        .min_by_key(|(distance, _)| *distance)
        .filter(|(distance, c)| *distance <= 1.max(name.chars().count().max(c.chars().count()) / 2))
        .map(|(_, c)| c)
}

/// A mend: the nearest name, or all of them where none is near.
pub(crate) fn mend(name: &str, candidates: &[&str]) -> String {
    match nearest(name, candidates.iter().copied()) {
        Some(near) => format!("did you mean `{near}`?"),
        None if candidates.is_empty() => "none is known here".to_owned(),
        None => format!("known here: {}", list(candidates)),
    }
}

/// Names in backticks, comma between.
fn list(names: &[&str]) -> String {
    names.iter().map(|n| format!("`{n}`")).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slip_finds_its_word_and_nonsense_finds_none() {
        let words = ["reflectance", "emission", "kind"];
        assert_eq!(nearest("reflectence", words), Some("reflectance"));
        assert_eq!(nearest("Kind", words), Some("kind"));
        assert_eq!(nearest("xyzzyplugh", words), None);
        assert!(mend("xyzzyplugh", &words).contains("`emission`"));
    }
}
