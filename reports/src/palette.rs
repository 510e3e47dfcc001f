//! Colours that can be told apart with every kind of colour vision: Okabe and Ito's palette.

/// Red, green and blue, 0 to 255.
pub type Rgb = [u8; 3];

/// Orange.
pub const ORANGE: Rgb = [230, 159, 0];
/// Sky blue.
pub const SKY_BLUE: Rgb = [86, 180, 233];
/// Bluish green.
pub const BLUISH_GREEN: Rgb = [0, 158, 115];
/// Yellow.
pub const YELLOW: Rgb = [240, 228, 66];
/// Blue.
pub const BLUE: Rgb = [0, 114, 178];
/// Vermilion.
pub const VERMILION: Rgb = [213, 94, 0];
/// Reddish purple.
pub const REDDISH_PURPLE: Rgb = [204, 121, 167];
