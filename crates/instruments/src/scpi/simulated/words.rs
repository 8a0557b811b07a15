//! The words of a command: its header in short form, its channel, and its arguments.

/// A command.
#[derive(Debug, PartialEq)]
pub(super) struct Words<'l> {
    /// The header in short form, without channels and without what may be left out, such as `FUNC:ARB:SRAT`.
    pub(super) header: String,
    /// The last number in the header.
    pub(super) channel: usize,
    pub(super) is_query: bool,
    pub(super) arguments: Vec<&'l str>,
}

/// The commands of a line. Those with data reach to its end, because a block may contain anything.
pub(super) fn commands(line: &str) -> Vec<&str> {
    if line.contains('#') { vec![line] } else { line.split(';').map(str::trim).filter(|one| !one.is_empty()).collect() }
}

impl<'l> Words<'l> {
    pub(super) fn of(command: &'l str) -> Self {
        let (head, rest) = command.split_once(char::is_whitespace).unwrap_or((command, ""));
        let (head, is_query) = head.strip_suffix('?').map_or((head, false), |head| (head, true));
        let mut channel = 1;
        let mut nodes: Vec<String> = Vec::new();
        for node in head.trim_start_matches(':').split(':') {
            let word = node.trim_end_matches(|c: char| c.is_ascii_digit());
            channel = node[word.len()..].parse().unwrap_or(channel);
            nodes.push(short(word));
        }
        nodes.retain(|node| {
            !matches!(&**node, "SOUR" | "LEV" | "IMM" | "AMPL" | "STAT" | "MAIN") || head.starts_with('*')
        });
        // Its source and level are those of a trigger.
        let lower = head.to_ascii_uppercase();
        if nodes.first().is_some_and(|first| matches!(&**first, "TRIG" | "WAV")) {
            if lower.contains(":SOUR") {
                nodes.push("SOUR".into())
            }
            if lower.contains(":LEV") {
                nodes.push("LEV".into())
            }
        }
        if nodes.first().is_some_and(|first| first == "BURS") && lower.contains(":STAT") {
            nodes.push("STAT".into())
        }
        let rest = rest.trim_start();
        let arguments = if rest.contains('#') {
            rest.splitn(2, ',').collect()
        } else {
            rest.split(',').map(str::trim).filter(|word| !word.is_empty()).collect()
        };
        Words { header: nodes.join(":"), channel, is_query, arguments }
    }
}

/// The short form of a word: four letters, or three if the fourth one is a vowel.
pub(super) fn short(word: &str) -> String {
    let word = word.to_ascii_uppercase();
    let mut letters: Vec<char> = word.chars().collect();
    if letters.len() > 4 && !word.starts_with('*') {
        letters.truncate(if matches!(letters[3], 'A' | 'E' | 'I' | 'O' | 'U') { 3 } else { 4 });
    }
    letters.into_iter().collect()
}
