//! Common Data Representation, the encoding of messages in ROS 2: numbers aligned to their size, in the byte order that the
//! first bytes state.

/// Reads the parts of a message from front to back. Errors are the rest of a sentence about the file.
#[derive(Debug, Clone)]
pub struct CdrReader<'a> {
    bytes: &'a [u8],
    position: usize,
    is_big_endian: bool,
    max_alignment: usize,
}

impl<'a> CdrReader<'a> {
    /// A reader of `message`, which begins with the representation and two bytes of options.
    ///
    /// # Errors
    ///
    /// If it is in another representation than plain CDR of version 1 or 2.
    pub fn new(message: &'a [u8]) -> Result<Self, String> {
        let Some((&[high, kind, _, _], bytes)) = message.split_first_chunk() else {
            return Err("has a CDR message without its four first bytes".to_owned());
        };
        let max_alignment = match (high, kind) {
            (0, 0 | 1) => 8,
            (0, 6 | 7) => 4,
            _ => return Err(format!("has a CDR message in the unknown representation {high:02x}{kind:02x}")),
        };
        Ok(Self { bytes, position: 0, is_big_endian: kind % 2 == 0, max_alignment })
    }

    /// The next `n` bytes as they are.
    fn take(&mut self, n: usize) -> Result<&'a [u8], String> {
        let end = self.position.checked_add(n);
        let taken = end.and_then(|end| self.bytes.get(self.position..end)).ok_or_else(|| {
            let (needed, n_bytes) = (n, self.bytes.len());
            format!("has a CDR message that needs {needed} bytes at {} of {n_bytes}", self.position)
        })?;
        self.position += n;
        Ok(taken)
    }

    fn number<const N: usize>(&mut self) -> Result<[u8; N], String> {
        self.position = self.position.next_multiple_of(N.min(self.max_alignment));
        let mut bytes: [u8; N] = self.take(N)?.try_into().map_err(|_| "is damaged".to_owned())?;
        if self.is_big_endian {
            bytes.reverse();
        }
        Ok(bytes)
    }

    /// A byte.
    pub fn u8(&mut self) -> Result<u8, String> {
        Ok(self.take(1)?[0])
    }

    /// A number of four bytes.
    pub fn u32(&mut self) -> Result<u32, String> {
        self.number().map(u32::from_le_bytes)
    }

    /// A number of four bytes with a sign.
    pub fn i32(&mut self) -> Result<i32, String> {
        self.number().map(i32::from_le_bytes)
    }

    /// A number of eight bytes with a fraction.
    pub fn f64(&mut self) -> Result<f64, String> {
        self.number().map(f64::from_le_bytes)
    }

    /// `N` numbers of eight bytes with a fraction.
    pub fn f64s<const N: usize>(&mut self) -> Result<[f64; N], String> {
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            *number = self.f64()?;
        }
        Ok(numbers)
    }

    /// A text, without the zero that ends it.
    pub fn text(&mut self) -> Result<&'a str, String> {
        let bytes = self.bytes()?;
        let bytes = bytes.strip_suffix(&[0]).unwrap_or(bytes);
        std::str::from_utf8(bytes).map_err(|_| "has a CDR message with a text that is not UTF-8".to_owned())
    }

    /// Bytes, after their number.
    pub fn bytes(&mut self) -> Result<&'a [u8], String> {
        let n = self.u32()?;
        self.take(n as usize)
    }

    /// A list of elements, after their number; `element` reads one.
    pub fn list<T>(
        &mut self,
        mut element: impl FnMut(&mut Self) -> Result<T, String>,
    ) -> Result<Vec<T>, String> {
        let n = self.u32()?;
        // Grown as elements are found: their number may be false.
        let mut list = Vec::new();
        for _ in 0..n {
            list.push(element(self)?);
        }
        Ok(list)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_aligned_and_turned() {
        let little = [0, 1, 0, 0, 7, 0, 0, 0, 5, 0, 0, 0];
        let big = [0, 0, 0, 0, 7, 0, 0, 0, 0, 0, 0, 5];
        for message in [little, big] {
            let mut reader = CdrReader::new(&message).unwrap();
            assert_eq!((reader.u8(), reader.u32()), (Ok(7), Ok(5)));
            assert!(reader.u8().is_err());
        }
    }

    #[test]
    fn the_second_version_aligns_to_four() {
        let mut message = vec![0, 7, 0, 0, 1, 0, 0, 0];
        message.extend(2.5_f64.to_le_bytes());
        let mut reader = CdrReader::new(&message).unwrap();
        assert_eq!((reader.u32(), reader.f64()), (Ok(1), Ok(2.5)));
    }

    #[test]
    fn lists_and_texts_that_claim_more_than_there_is_are_refused() {
        let message = [0, 1, 0, 0, 255, 255, 255, 255, 65, 0];
        assert!(
            CdrReader::new(&message)
                .unwrap()
                .text()
                .unwrap_err()
                .contains("needs 4294967295 bytes at 4 of 6")
        );
        assert!(CdrReader::new(&message).unwrap().list(CdrReader::f64).is_err());
        assert!(CdrReader::new(&[0, 3, 0, 0]).unwrap_err().contains("0003"));
        assert!(CdrReader::new(&[0, 1]).is_err());
    }
}
