//! What the pages have in common: the head of the document and the style of text, links and tables.

use super::escaped;

const DOCUMENT: &str = include_str!("page/document.html");
const THEME: &str = include_str!("page/theme.css");

/// A whole page of a title (text), a style of its own and a body (HTML).
pub(crate) fn document(title: &str, style: &str, body: &str) -> String {
    let parts = [
        ("title", escaped(title)),
        ("theme", THEME.into()),
        ("style", style.into()),
        ("body", body.into()),
    ];
    fill(DOCUMENT, &parts)
}

/// Fills in the `{{name}}`s of a template. What is filled in is not looked through, so that it may hold any text.
pub(super) fn fill(template: &str, parts: &[(&str, String)]) -> String {
    let size: usize = parts.iter().map(|(_, text)| text.len()).sum();
    let mut out = String::with_capacity(template.len() + size);
    let mut rest = template;
    while let Some((before, after)) = rest.split_once("{{") {
        out.push_str(before);
        let Some((name, after)) = after.split_once("}}") else {
            break;
        };
        if let Some((_, text)) = parts.iter().find(|(own, _)| *own == name) {
            out.push_str(text);
        }
        rest = after;
    }
    out.push_str(rest);
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_filled_in_is_text() {
        let page = document("a < {{body}}", "p { x: {{title}} }\n", "<p>{{theme}}</p>\n");
        assert!(page.contains("<title>a &lt; {{body}}</title>"));
        assert!(page.contains("p { x: {{title}} }\n</style>"));
        assert!(page.contains("<body>\n<p>{{theme}}</p>\n</body>"));
        assert_eq!(page.matches(":root").count(), 1);
    }
}
