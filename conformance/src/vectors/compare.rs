//! Compares what an oracle answered with what the library answers, field by field.

use serde::Serialize;
use serde_json::Value;

/// Arguments of operations in histories. They stand beside the state in the same object and are not compared.
const ARGUMENTS: [&str; 14] = [
    "op",
    "anim",
    "low",
    "high",
    "rate",
    "velocity_in",
    "omega_in",
    "amount",
    "factor",
    "dt",
    "with_frame",
    "motion",
    "speed",
    "hold_key",
];

/// A field whose values differ.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Mismatch {
    /// Path from `out` or `ops`, e.g. `out.frame.origin[2]`.
    pub field: String,
    /// The oracle's value.
    pub expected: Value,
    /// The library's value; absent when it gave none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub actual: Option<Value>,
}

/// What became of one vector.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// Every field has the same bits.
    Exact,
    /// The oracle has no answer; nothing is compared.
    LeftOut,
    /// This field differs (the first, in the order of the oracle's answer).
    Different(Mismatch),
}

/// Whether the oracle answered this vector at all (`null` and exceptions are no answers).
pub fn has_answer(vector: &Value) -> bool {
    match (vector.get("out"), vector.get("ops")) {
        (Some(out), _) => !out.is_null() && out.get("exception").is_none(),
        (None, Some(ops)) => ops
            .as_array()
            .is_some_and(|ops| ops.first().is_some_and(|op| op.get("exception").is_none())),
        (None, None) => false,
    }
}

/// Compares the expected part of a vector with the actual `out` or `ops`.
pub fn compare_vector(vector: &Value, actual: &Value) -> Verdict {
    if !has_answer(vector) {
        return Verdict::LeftOut;
    }
    let mut path = String::new();
    let difference = match (vector.get("out"), vector.get("ops")) {
        (Some(out), _) => {
            path.push_str("out");
            difference(&mut path, out, Some(actual))
        }
        (None, Some(ops)) => {
            path.push_str("ops");
            operations(&mut path, ops, actual)
        }
        (None, None) => None,
    };
    difference.map_or(Verdict::Exact, Verdict::Different)
}

/// A history, up to the first operation in which the oracle's code threw.
fn operations(path: &mut String, expected: &Value, actual: &Value) -> Option<Mismatch> {
    for (index, operation) in expected.as_array()?.iter().enumerate() {
        if operation.get("exception").is_some() {
            break;
        }
        let length = path.len();
        path.push_str(&format!("[{index}]"));
        let fields = operation.as_object()?;
        for (key, value) in fields
            .iter()
            .filter(|(key, _)| !ARGUMENTS.contains(&key.as_str()))
        {
            let inner = path.len();
            path.push('.');
            path.push_str(key);
            let found = difference(
                path,
                value,
                actual.get(index).and_then(|operation| operation.get(key)),
            );
            if found.is_some() {
                return found;
            }
            path.truncate(inner);
        }
        path.truncate(length);
    }
    None
}

/// The first field of `expected` that `actual` does not match. What only `actual` has is not looked at.
fn difference(path: &mut String, expected: &Value, actual: Option<&Value>) -> Option<Mismatch> {
    let length = path.len();
    match (expected, actual) {
        (Value::Object(fields), Some(Value::Object(_))) => {
            for (key, value) in fields {
                path.push('.');
                path.push_str(key);
                let found = difference(path, value, actual.and_then(|actual| actual.get(key)));
                if found.is_some() {
                    return found;
                }
                path.truncate(length);
            }
            None
        }
        (Value::Array(items), Some(Value::Array(others))) if items.len() == others.len() => {
            for (index, (item, other)) in items.iter().zip(others).enumerate() {
                path.push_str(&format!("[{index}]"));
                let found = difference(path, item, Some(other));
                if found.is_some() {
                    return found;
                }
                path.truncate(length);
            }
            None
        }
        (expected, Some(actual)) if same_leaf(expected, actual) => None,
        (expected, actual) => Some(Mismatch {
            field: path.clone(),
            expected: expected.clone(),
            actual: actual.cloned(),
        }),
    }
}

/// Numbers by the bits of their f64, hexadecimal ids by value, all else by equality.
pub(crate) fn same_leaf(expected: &Value, actual: &Value) -> bool {
    match (expected, actual) {
        (Value::Number(a), Value::Number(b)) => {
            matches!((a.as_f64(), b.as_f64()), (Some(a), Some(b)) if a.to_bits() == b.to_bits())
        }
        (Value::String(a), Value::String(b)) => {
            a == b || matches!((hex(a), hex(b)), (Some(a), Some(b)) if a == b)
        }
        _ => expected == actual,
    }
}

fn hex(text: &str) -> Option<u64> {
    let digits = text
        .strip_prefix("0x")
        .or_else(|| text.strip_prefix("0X"))?;
    u64::from_str_radix(digits, 16).ok()
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn zero_has_a_sign_and_ids_are_numbers() {
        let vector = json!({"fn": "f", "in": {}, "out": {"cell": "0x0A", "x": [0.0, 1]}});
        assert_eq!(
            compare_vector(&vector, &json!({"cell": "0xa", "x": [0, 1.0], "more": 1})),
            Verdict::Exact
        );
        let Verdict::Different(mismatch) =
            compare_vector(&vector, &json!({"cell": "0xa", "x": [-0.0, 1]}))
        else {
            panic!("a sign of zero was overlooked");
        };
        assert_eq!(mismatch.field, "out.x[0]");
    }

    #[test]
    fn missing_is_never_equal() {
        let vector = json!({"fn": "f", "in": {}, "out": {"plane": null}});
        assert!(matches!(
            compare_vector(&vector, &json!({})),
            Verdict::Different(_)
        ));
        assert_eq!(
            compare_vector(&vector, &json!({"plane": null})),
            Verdict::Exact
        );
    }

    #[test]
    fn exceptions_are_left_out() {
        let vector = json!({"fn": "f", "in": {}, "out": {"exception": "Boom"}});
        assert_eq!(compare_vector(&vector, &json!({})), Verdict::LeftOut);
        let history = json!({"fn": "f", "ops": [
            {"op": "a", "dt": 1, "x": 1}, {"op": "b", "exception": "Boom"}, {"op": "a", "exception": "after an exception"}]});
        assert_eq!(compare_vector(&history, &json!([{"x": 1}])), Verdict::Exact);
        assert!(matches!(
            compare_vector(&history, &json!([{"x": 2}])),
            Verdict::Different(_)
        ));
    }
}
