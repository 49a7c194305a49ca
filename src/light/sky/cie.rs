//! The fifteen types of CIE S 011/E:2003 (ISO 15469:2004).

use super::Coefficients;

/// Number of types.
pub const CIE_TYPES: u8 = 15;

/// Gradations I to VI and indicatrices 1 to 6 of the standard's table, put together type by type.
const GRADATION: [(f64, f64); 6] =
    [(4.0, -0.70), (1.1, -0.80), (0.0, -1.0), (-1.0, -0.55), (-1.0, -0.32), (-1.0, -0.15)];
const INDICATRIX: [(f64, f64, f64); 6] = [
    (0.0, -1.0, 0.0),
    (2.0, -1.5, 0.15),
    (5.0, -2.5, 0.30),
    (10.0, -3.0, 0.45),
    (16.0, -3.0, 0.30),
    (24.0, -2.8, 0.15),
];
const TYPES: [(usize, usize); CIE_TYPES as usize] = [
    (0, 0),
    (0, 1),
    (1, 0),
    (1, 1),
    (2, 0),
    (2, 1),
    (2, 2),
    (2, 3),
    (3, 1),
    (3, 2),
    (3, 3),
    (4, 3),
    (4, 4),
    (5, 4),
    (5, 5),
];

/// The five numbers of a type, 1 to 15.
#[must_use]
pub fn cie_coefficients(number: u8) -> Option<Coefficients> {
    let (gradation, group) = *TYPES.get(usize::from(number).checked_sub(1)?)?;
    let ((a, b), (c, d, e)) = (GRADATION[gradation], INDICATRIX[group]);
    Some(Coefficients { a, b, c, d, e })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_are_types_one_to_fifteen() {
        assert!(cie_coefficients(0).is_none() && cie_coefficients(16).is_none());
        assert!((1..=15).all(|n| cie_coefficients(n).is_some()));
    }
}
