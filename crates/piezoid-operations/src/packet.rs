//! Requests and answers as bytes, for memory and network.
//!
//! ```text
//! u32        length of the head, little-endian
//! head       JSON; spaces up to a multiple of 8 bytes from the start
//! content    what the head names, one after the other, each filled up to a multiple of 8 bytes
//! ```
//! The head of a request is the request, with `bytes`: `[["log.csv", 1234], ...]`, names and lengths of the files. The
//! head of an answer has `result` or `error`, then `series`, names and numbers of samples, and `bytes` as above. A
//! sample is a double, little-endian.

use crate::{Request, run};
use piezoid::Error;
use piezoid::progress::Progress;
use piezoid_numerics::words::Words;
use piezoid_verbs::File;
use serde_json::{Map, Value, json};

/// Alignment of each part [bytes]: a browser reads doubles only at multiples of it.
const ALIGN: usize = 8;

/// The answer to a request, both as bytes. An error is an answer too.
///
/// ```
/// use piezoid::progress::Stage;
/// let answer = piezoid_operations::answered(b"nonsense", &mut Stage::ignore);
/// assert!(String::from_utf8_lossy(&answer).contains("not a request"));
/// ```
pub fn answered(request: &[u8], progress: &mut Progress) -> Vec<u8> {
    match unpacked(request).and_then(|(request, files)| run(&request, &files, progress)) {
        Ok(output) => {
            let mut packed = head(&json!(output));
            for (_, samples) in &output.series {
                samples.iter().for_each(|sample| packed.extend(sample.to_le_bytes()));
            }
            for file in &output.files {
                packed.extend(&file.bytes);
                fill(&mut packed, 0);
            }
            packed
        }
        Err(Error::Cancelled { .. }) => head(&json!({"error": "cancelled", "cancelled": true})),
        Err(error) => {
            let advice: Map<String, Value> = error.advice().iter().map(|(k, v)| (k.to_string(), v.clone())).collect();
            head(&json!({"error": error.message(&Marks), "advice": advice}))
        }
    }
}

/// True if the request moves an instrument, which must be stopped in an orderly way. Its files are not read.
pub fn moves(request: &[u8]) -> bool {
    document(request).is_ok_and(|(head, _)| ["acquire", "campaign", "moves"].iter().any(|call| head["call"] == *call))
}

/// The words of an answer: options stand in braces, and the page writes their labels.
pub(crate) struct Marks;

impl Words for Marks {
    fn option(&self, name: &str) -> String {
        format!("{{{name}}}")
    }

    fn remedy(&self, name: &str, value: &Value) -> String {
        match value {
            Value::Null | Value::Bool(true) => format!("`{{{name}}}`"),
            value => format!("`{{{name}}}` = {value}"),
        }
    }

    fn setting(&self, name: &str, value: &str) -> String {
        format!("{{{name}}} = {value}")
    }

    fn list(&self, name: &str) -> String {
        name.into()
    }
}

/// An error as a packed answer.
pub fn refused(error: &str) -> Vec<u8> {
    head(&json!({"error": error}))
}

/// The length of a head, and the head.
fn head(document: &Value) -> Vec<u8> {
    let mut packed = vec![0; 4];
    packed.extend(document.to_string().bytes());
    fill(&mut packed, b' ');
    let length = (packed.len() - 4) as u32;
    packed[..4].copy_from_slice(&length.to_le_bytes());
    packed
}

fn fill(packed: &mut Vec<u8>, with: u8) {
    packed.resize(packed.len().next_multiple_of(ALIGN), with);
}

fn no(why: &str) -> Error {
    Error::Content(format!("this is not a request: {why}"))
}

/// The head of a request, and where it ends.
fn document(packed: &[u8]) -> Result<(Value, usize), Error> {
    let (length, rest) = packed.split_first_chunk::<4>().ok_or_else(|| no("it has fewer than 4 bytes"))?;
    let length = u32::from_le_bytes(*length) as usize;
    let head = rest.get(..length).ok_or_else(|| no("it ends within its head"))?;
    let head = serde_json::from_slice(head).map_err(|e| no(&format!("its head is not JSON: {e}")))?;
    Ok((head, 4 + length))
}

/// The request in bytes, and its files.
fn unpacked(packed: &[u8]) -> Result<(Request, Vec<File>), Error> {
    let (mut head, mut at) = document(packed)?;
    let bytes = head.as_object_mut().and_then(|head| head.remove("bytes")).unwrap_or_default();
    let names: Option<Vec<(String, usize)>> = serde_json::from_value(bytes).map_err(|e| no(&e.to_string()))?;
    let mut file = |(name, length): (String, usize)| {
        let end = at.checked_add(length).filter(|end| *end <= packed.len());
        let end = end.ok_or_else(|| no(&format!("it ends within the file `{name}`")))?;
        let file = File::new(name, &packed[at..end]);
        at = end.next_multiple_of(ALIGN);
        Ok(file)
    };
    let files = names.unwrap_or_default().into_iter().map(&mut file).collect::<Result<_, Error>>()?;
    Ok((Request::of(head)?, files))
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid::progress::Stage;

    /// A request with its files as bytes.
    fn packed(request: &Value, files: &[(&str, &str)]) -> Vec<u8> {
        let mut request = request.clone();
        request["bytes"] = files.iter().map(|(name, text)| json!([name, text.len()])).collect();
        let mut packed = head(&request);
        for (_, text) in files {
            packed.extend(text.bytes());
            fill(&mut packed, 0);
        }
        packed
    }

    /// The head of an answer, and what follows it.
    fn parts(answer: &[u8]) -> (Value, &[u8]) {
        let length = u32::from_le_bytes(answer[..4].try_into().unwrap()) as usize;
        (serde_json::from_slice(&answer[4..4 + length]).unwrap(), &answer[4 + length..])
    }

    #[test]
    fn an_answer_holds_its_result_and_its_series() {
        let log = "t_s,u_V,y_um\n0,0,0.5\n0.001,1,5.25\n";
        let request = json!({"call": "inspect", "files": {"data": ["b.csv"]}});
        let answer = answered(&packed(&request, &[("a.csv", "x"), ("b.csv", log)]), &mut Stage::ignore);
        let (head, content) = parts(&answer);
        assert_eq!((head["result"]["record"]["ts"].as_f64(), (answer.len() - content.len()) % 8), (Some(0.001), 0));
        assert_eq!(head["series"], json!([["u", 2], ["y", 2]]));
        let sample = |k: usize| f64::from_le_bytes(content[8 * k..8 * k + 8].try_into().unwrap());
        assert_eq!([0, 1, 2, 3].map(sample), [0.0, 1.0, 0.5, 5.25]);
        assert_eq!(head["bytes"][0][0], "profile.toml");
        assert!(content[32..].starts_with(b"time_col"));
    }

    #[test]
    fn damaged_requests_are_refused_with_the_reason() {
        let request = json!({"call": "inspect", "files": {"data": ["a.csv"]}});
        let whole = packed(&request, &[("a.csv", "t_s,u_V,y_um\n0,1,2\n1,2,3\n")]);
        let message = |bytes: &[u8]| {
            let answer = answered(bytes, &mut Stage::ignore);
            parts(&answer).0["error"].as_str().unwrap_or_default().to_string()
        };
        assert_eq!(message(&whole), "");
        for end in 0..whole.len() - 8 {
            assert!(message(&whole[..end]).starts_with("this is not a request: "), "{end}");
        }
        let of = |request: Value| message(&packed(&request, &[]));
        assert!(
            of(json!({"call": "fly"})).starts_with("there is no call called `fly`"),
            "{}",
            of(json!({"call": "fly"}))
        );
        assert!(
            of(json!({"call": "inspect"})).contains("inspect takes 1 or more of the files `data`, but 0 are given")
        );
        assert!(of(request.clone()).contains("a.csv"));
        assert!(of(json!({"call": "inspect", "file": 1})).contains("a request is such as"));
        assert!(of(json!({"call": "inspect", "files": {"log": ["a"]}})).contains("role of files"));
    }

    #[test]
    fn the_files_of_a_rig_get_a_proposed_use_and_reasons_with_options_in_braces() {
        let row = |k: u32, u: f64| format!("{},{u},{}\n", f64::from(k) * 1e-3, 0.1 * u);
        let file = |u: &dyn Fn(u32) -> f64| {
            String::from("t_s,u_V,y_um\n") + &(0..900).map(|k| row(k, u(k))).collect::<String>()
        };
        let large = file(&|k| 100.0 - (f64::from(k % 128) - 64.0).abs() * 100.0 / 64.0);
        let small = file(&|k| 50.0 + f64::from(k.wrapping_mul(2_654_435_761) >> 16) / 65536.0);
        let unknown = "A,B,C\n1,5,2\n3,4,9\n7,1,5\n4,2,8\n";
        let request = json!({"call": "inspect", "files": {"data": ["large.csv", "small.csv", "unknown.csv"]}});
        let files = [("large.csv", &*large), ("small.csv", &small), ("unknown.csv", unknown)];
        let answer = answered(&packed(&request, &files), &mut Stage::ignore);
        let files = parts(&answer).0["result"]["files"].clone();
        assert_eq!((&files[0]["use"]["use"], &files[1]["use"]["use"]), (&json!("training"), &json!("small-signal")));
        assert!(files[1]["use"]["because"].as_str().unwrap().contains("1 % of the largest range, 100 V"), "{files}");
        assert!(
            files[2]["use"].is_null() && files[2]["problems"][0].as_str().unwrap().contains("`{input_col}`"),
            "{files}"
        );
    }
}
