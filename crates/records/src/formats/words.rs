//! Words of the names of columns, in the languages of common programs.
//!
//! A word of up to four Latin letters is a whole word of a name (`u`, `pos`); a longer one may be part of one
//! (`Piezospannung`), but for two that are part of others (`extension`, `tempsensor`).

use super::column::Column;
use super::units;

/// Words of a time.
pub(super) const TIME: &str = "\
    t time times timestamp zeit temps tempo tiempo clock sec seconds xvalue xaxis \
    elapsed tijd tid czas čas 时间 時間 시간 время";

/// Words of an input.
pub(super) const INPUT: &str = "\
    u v in cmd hv dac ao volt volts vin uin drive voltage spannung tension voltaje tensione input command excitation \
    stimulus amplifier spanning napięcie napětí stellgröße 电压 電圧 전압 напряжение";

/// Words of an output.
pub(super) const OUTPUT: &str = "\
    y x z pos disp weg hub gap cap meas displacement deplacement déplacement position auslenkung travel stroke \
    abstand distance sensor measured deflection elongation extension encoder interferometer response desplazamiento \
    spostamento posizione strain vibration outputdata ist istwert verplaatsing positie przemieszczenie posunutí 位移 変位 \
    변위 перемещение";

/// Words of an output that only is requested, and of its error.
pub(super) const REQUESTED: &str = "\
    ref set soll goal err cmd command reference setpoint target desired demand consigne error deviation abweichung \
    sollwert trajectory";

/// Words of other columns.
pub(super) const OTHER: &str = "\
    temp trig temperature temperatur trigger velocity speed acceleration force index sample comment status counter \
    wavelength latency";

impl Column {
    /// True if its name has one of these words.
    pub(super) fn has_word(&self, words: &str) -> bool {
        // `PosCmd` is two words.
        let mut name = String::new();
        for c in units::split(&self.name).0.chars() {
            if c.is_uppercase() && name.ends_with(char::is_lowercase) {
                name.push(' ');
            }
            name.push(c);
        }
        let name = name.to_lowercase();
        let own: Vec<&str> = name.split(|c: char| !c.is_alphabetic()).filter(|word| !word.is_empty()).collect();
        let whole = own.concat();
        words.split_whitespace().any(|word| {
            if (word.chars().count() > 4 || !word.is_ascii()) && word != "tension" && word != "temps" {
                return whole.contains(word);
            }
            // `yref` and `sollwert` end or begin so.
            let part = ["ref", "soll"].contains(&word);
            own.iter().any(|own| *own == word || part && (own.starts_with(word) || own.ends_with(word)))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_words_stand_alone_and_long_ones_may_be_part_of_a_name() {
        let has = |name: &str, words| Column::new(name.into()).has_word(words);
        for (name, words) in [
            ("U1 (V)", INPUT),
            ("Piezospannung [V]", INPUT),
            ("OutputData", OUTPUT),
            ("x_cap", OUTPUT),
            ("yref_um", REQUESTED),
            ("PosCmd (um)", REQUESTED),
            ("Regelabweichung [\u{b5}m]", REQUESTED),
            ("\u{6642}\u{9593}[s]", TIME),
        ] {
            assert!(has(name, words), "{name}");
        }
        for (name, words) in
            [("ultra", INPUT), ("disposal", OUTPUT), ("Voltage", OUTPUT), ("total", TIME), ("Extension", INPUT)]
        {
            assert!(!has(name, words), "{name}");
        }
    }
}
