//! The XML of WINDOW: which data are taken, and what is refused.

use roxmltree::{Document, Node};

use super::{Bsdf, KlemsBasis, Passage, Scattering};
use crate::{Error, Result};

/// Most that may leave of what arrives: in one patch, for the element files of WINDOW itself make up to 1.042 in the ring that
/// grazes the surface; and from all directions together, where six digits round.
const MOST_OF_PATCH: f64 = 1.05;
const MOST_OF_ALL: f64 = 1.001;
/// The data that are for the eye.
const VISIBLE: &str = "Visible";

impl Bsdf {
    /// Reads a file's text; the visible data are taken.
    ///
    /// A transmission that is told one way alone is the same the other way (Helmholtz); a reflection that is not told is none.
    ///
    /// # Errors
    /// Malformed XML or data; impossible if more light leaves than arrives (beyond 5 % in a patch, 0.1 % from all directions
    /// together) or a value is negative; unsupported for tensor
    /// trees, data by rows, bases of the file's own and files without visible data. Each names the line.
    pub fn from_xml(text: &str) -> Result<Self> {
        let document = Document::parse(text)
            .map_err(|e| Error::malformed(format!("no well-formed XML: {e}")).at_line(e.pos().row as usize))?;
        let file = File { document: &document };
        let root = document.root_element();
        if root.tag_name().name() != "WindowElement" {
            return Err(file.malformed(root, format!("<{}> is no <WindowElement>", root.tag_name().name())));
        }
        file.check_structure(root)?;
        let mut bsdf = Self { scattering: [const { None }; 4] };
        let mut others = Vec::new();
        for data in children(root, "WavelengthData") {
            let wavelength = file.text(data, "Wavelength")?;
            if wavelength != VISIBLE {
                others.push(wavelength);
                continue;
            }
            for block in children(data, "WavelengthDataBlock") {
                let name = file.text(block, "WavelengthDataDirection")?;
                let Some(passage) = Passage::ALL.into_iter().find(|p| p.name() == name) else {
                    continue; // absorptances
                };
                if bsdf.scattering(passage).is_some() {
                    return Err(file.malformed(block, format!("a second block of {name}")));
                }
                bsdf.scattering[passage as usize] = Some(file.scattering(block, passage)?);
            }
        }
        if bsdf.scattering.iter().all(Option::is_none) {
            let found = if others.is_empty() { "none at all".to_owned() } else { others.join(", ") };
            return Err(file
                .at(root, Error::unsupported(format!("no visible scattering data; found: {found}")))
                .mend("export the element with its visible data"));
        }
        bsdf.complete();
        bsdf.check_energy(&file, root)?;
        Ok(bsdf)
    }

    /// Transmission one way tells that of the other.
    fn complete(&mut self) {
        let [front, back] = [Passage::TransmissionFront as usize, Passage::TransmissionBack as usize];
        for (known, missing) in [(front, back), (back, front)] {
            if self.scattering[missing].is_none() {
                self.scattering[missing] = self.scattering[known].as_ref().map(Scattering::reversed);
            }
        }
    }

    fn check_energy(&self, file: &File<'_, '_>, root: Node<'_, '_>) -> Result<()> {
        for [transmission, reflection] in [
            [Passage::TransmissionFront, Passage::ReflectionFront],
            [Passage::TransmissionBack, Passage::ReflectionBack],
        ] {
            let shares = |p: Passage| self.scattering(p).map_or_else(Vec::new, Scattering::directional_hemispherical);
            let (passed, reflected) = (shares(transmission), shares(reflection));
            let sum = |i: usize| passed.get(i).unwrap_or(&0.0) + reflected.get(i).unwrap_or(&0.0);
            let Some(worst) = (0..passed.len().max(reflected.len())).max_by(|a, b| sum(*a).total_cmp(&sum(*b))) else {
                continue;
            };
            let both = [transmission, reflection].map(|p| self.scattering(p).map_or(0.0, Scattering::hemispherical));
            let all: f64 = both.iter().sum();
            let excess = if sum(worst) > MOST_OF_PATCH {
                Some(format!("{:.4} of the light in incident patch {}", sum(worst), worst + 1))
            } else {
                (all > MOST_OF_ALL).then(|| format!("{all:.4} of the light from all directions"))
            };
            if let Some(excess) = excess {
                let message = format!(
                    "{} and {} make {excess}: more leaves than arrives",
                    transmission.name(),
                    reflection.name()
                );
                let block = file.block(root, transmission).or_else(|| file.block(root, reflection)).unwrap_or(root);
                return Err(file.at(block, Error::impossible(message)).mend("values are per steradian, not shares"));
            }
        }
        Ok(())
    }
}

/// A document that can say where something stands.
struct File<'a, 'input> {
    document: &'a Document<'input>,
}

impl File<'_, '_> {
    fn line(&self, offset: usize) -> usize {
        self.document.text_pos_at(offset).row as usize
    }

    fn at(&self, node: Node<'_, '_>, error: Error) -> Error {
        error.at_line(self.line(node.range().start))
    }

    fn malformed(&self, node: Node<'_, '_>, message: String) -> Error {
        self.at(node, Error::malformed(message))
    }

    /// Text of an element within another one.
    fn text<'b>(&self, node: Node<'b, '_>, name: &str) -> Result<&'b str> {
        let found = children(node, name).next().and_then(|n| n.text()).map(str::trim).filter(|t| !t.is_empty());
        found.ok_or_else(|| self.malformed(node, format!("<{}> has no <{name}>", node.tag_name().name())))
    }

    fn check_structure(&self, root: Node<'_, '_>) -> Result<()> {
        let Some(definition) = children(root, "DataDefinition").next() else {
            return Err(self.malformed(root, "no <DataDefinition>".into()));
        };
        let structure = self.text(definition, "IncidentDataStructure")?;
        if structure == "Columns" {
            return Ok(());
        }
        let what = if structure.starts_with("TensorTree") { "tensor trees are" } else { "it is" };
        let message = format!("incident data structure {structure}: {what} not supported in this version");
        Err(self.at(definition, Error::unsupported(message)).mend("export a matrix of Klems patches (Columns)"))
    }

    /// The visible block of one passage.
    fn block<'b, 'i>(&self, root: Node<'b, 'i>, passage: Passage) -> Option<Node<'b, 'i>> {
        let visible =
            children(root, "WavelengthData").filter(|d| self.text(*d, "Wavelength").is_ok_and(|w| w == VISIBLE));
        let mut blocks = visible.flat_map(|d| children(d, "WavelengthDataBlock"));
        blocks.find(|b| self.text(*b, "WavelengthDataDirection").is_ok_and(|name| name == passage.name()))
    }

    fn basis(&self, block: Node<'_, '_>, key: &str) -> Result<KlemsBasis> {
        let name = self.text(block, key)?;
        KlemsBasis::named(name).ok_or_else(|| {
            self.at(block, Error::unsupported(format!("angle basis `{name}` is not supported in this version")))
                .mend("export in LBNL/Klems Full, Half or Quarter")
        })
    }

    fn scattering(&self, block: Node<'_, '_>, passage: Passage) -> Result<Scattering> {
        let incident = self.basis(block, "ColumnAngleBasis")?;
        let outgoing = self.basis(block, "RowAngleBasis")?;
        let text = self.text(block, "ScatteringData")?;
        let wanted = incident.patches().len() * outgoing.patches().len();
        let mut values = Vec::with_capacity(wanted);
        // A slice of the document tells by where it lies the line of each number; a text with entities is none.
        let whole = self.document.input_text().as_bytes().as_ptr_range();
        let start = text.as_bytes().as_ptr_range().start as usize;
        let is_slice = (whole.start as usize..whole.end as usize).contains(&start);
        let words = text.split(|c: char| c == ',' || c.is_whitespace()).filter(|w| !w.is_empty());
        for word in words {
            let line = || {
                self.line(if is_slice { word.as_ptr() as usize - whole.start as usize } else { block.range().start })
            };
            let value: f64 = word.parse().ok().filter(|v: &f64| v.is_finite()).ok_or_else(|| {
                Error::malformed(format!("{}: `{word}` is not a number", passage.name())).at_line(line())
            })?;
            if value < 0.0 {
                let message = format!("{}: {value} sr⁻¹ is negative", passage.name());
                return Err(Error::impossible(message).mend("light cannot be taken away").at_line(line()));
            }
            values.push(value);
        }
        if values.len() != wanted {
            let message = format!("{}: {} values, the bases want {wanted}", passage.name(), values.len());
            return Err(self.malformed(block, message));
        }
        Ok(Scattering { incident, outgoing, values })
    }
}

/// Elements of a name below a node, at any depth.
fn children<'a, 'input>(node: Node<'a, 'input>, name: &str) -> impl Iterator<Item = Node<'a, 'input>> {
    node.descendants().filter(move |n| n.is_element() && n.tag_name().name() == name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    /// A file with one block for each passage, every value the same.
    fn file(blocks: &[(&str, f64)]) -> String {
        let data = |v: f64| vec![v.to_string(); 41 * 41].join(",");
        let block = |(name, v): &(&str, f64)| {
            format!(
                "<WavelengthData>\n<Wavelength unit=\"Integral\">Visible</Wavelength>\n<WavelengthDataBlock>\n<WavelengthDataDirection>{name}</WavelengthDataDirection>\n<ColumnAngleBasis>LBNL/Klems Quarter</ColumnAngleBasis>\n<RowAngleBasis>LBNL/Klems Quarter</RowAngleBasis>\n<ScatteringData>\n{}\n</ScatteringData>\n</WavelengthDataBlock>\n</WavelengthData>\n",
                data(*v)
            )
        };
        let blocks: String = blocks.iter().map(block).collect();
        format!(
            "<WindowElement><Optical><Layer>\n<DataDefinition><IncidentDataStructure>Columns</IncidentDataStructure></DataDefinition>\n{blocks}</Layer></Optical></WindowElement>"
        )
    }

    #[test]
    fn a_lambertian_sheet_passes_pi_times_its_value_from_everywhere() {
        let bsdf = Bsdf::from_xml(&file(&[("Transmission Front", 0.4 / PI), ("Reflection Back", 0.5 / PI)])).unwrap();
        for (passage, share) in [
            (Passage::TransmissionFront, 0.4),
            // By reciprocity.
            (Passage::TransmissionBack, 0.4),
            (Passage::ReflectionBack, 0.5),
        ] {
            let s = bsdf.scattering(passage).unwrap();
            assert!((s.hemispherical() - share).abs() < 1e-14, "{passage:?}");
            assert!(s.directional_hemispherical().iter().all(|d| (d - share).abs() < 1e-14));
        }
        assert!(bsdf.scattering(Passage::ReflectionFront).is_none());
    }

    #[test]
    fn light_goes_back_the_way_it_came() {
        // One way alone is open: arriving in patch 3, leaving in patch 20 (counted from 0).
        let n = 41;
        let only = |k: usize| if k == 20 * n + 3 { "0.2" } else { "0" };
        let one = (0..n * n).map(only).collect::<Vec<_>>().join(",");
        let even = vec!["0.1".to_owned(); n * n].join(",");
        let bsdf = Bsdf::from_xml(&file(&[("Transmission Front", 0.1)]).replace(&even, &one)).unwrap();
        let [front, back] =
            [Passage::TransmissionFront, Passage::TransmissionBack].map(|p| bsdf.scattering(p).unwrap());
        assert_eq!(front.value(20, 3), 0.2);
        // Backwards light arrives in patch 14, opposite to 20 in the ring of 9 to 20 (11 + 6 is 5 of 12), and leaves in 7,
        // opposite to 3 in the ring of 1 to 8 (2 + 4 is 6 of 8).
        assert_eq!(back.value(7, 14), 0.2);
        assert!((back.hemispherical() - front.hemispherical()).abs() < 1e-15);
    }

    #[test]
    fn files_that_cannot_be_name_the_line() {
        let good = file(&[("Transmission Front", 0.1)]);
        for (text, want) in [
            (good.replace("Columns", "TensorTree4"), "tensor trees are not supported"),
            (good.replace("Columns", "Rows"), "structure Rows"),
            (good.replace("Klems Quarter</Row", "Klems Odd</Row"), "`LBNL/Klems Odd` is not supported"),
            (good.replace("Visible", "Solar"), "no visible scattering data; found: Solar"),
            (good.replacen("0.1,", "-0.1,", 1), "-0.1 sr⁻¹ is negative"),
            (good.replacen("0.1,", "x,", 1), "`x` is not a number"),
            (good.replacen("0.1,", "NaN,", 1), "`NaN` is not a number"),
            (good.replacen("0.1,", "", 1), "1680 values, the bases want 1681"),
            (good.replace("</Optical>", ""), "no well-formed XML"),
            (good.replace("WindowElement", "Window"), "<Window> is no <WindowElement>"),
            (good.replace("RowAngleBasis", "Row"), "has no <RowAngleBasis>"),
            (file(&[("Transmission Front", 0.1), ("Transmission Front", 0.1)]), "a second block"),
            (String::new(), "no well-formed XML"),
        ] {
            let error = Bsdf::from_xml(&text).unwrap_err().in_file("w.xml").to_string();
            assert!(error.starts_with("w.xml:") && error.contains(want), "{want}: {error}");
        }
        let error = Bsdf::from_xml(&good.replacen("0.1,", "-1,", 1)).unwrap_err().in_file("w.xml").to_string();
        assert!(error.starts_with("w.xml:10:"), "{error}");
    }

    #[test]
    fn what_makes_light_is_refused() {
        let error = Bsdf::from_xml(&file(&[("Transmission Front", 0.2), ("Reflection Front", 0.15)])).unwrap_err();
        let text = error.in_file("w.xml").to_string();
        // (0.2 + 0.15) π
        assert!(text.starts_with("w.xml:5:") && text.contains("make 1.0996 of the light in incident patch"), "{text}");
        // 0.32 π, in each patch and so of all.
        let error = Bsdf::from_xml(&file(&[("Reflection Back", 0.32)])).unwrap_err().to_string();
        assert!(error.contains("make 1.0053 of the light from all directions"), "{error}");
        // From the back nothing is reflected.
        assert!(Bsdf::from_xml(&file(&[("Transmission Front", 0.31)])).is_ok());
    }
}
