//! The message tables in dbc/README.md are those that the DBCs give.

use canloop::schema::Profile;

const README: &str = include_str!("../dbc/README.md");

#[test]
fn the_readme_shows_the_messages_of_every_dbc() {
    for name in Profile::builtin_names() {
        let table = Profile::builtin(name).unwrap().dbc.markdown_table();
        let begin = format!("<!-- {name}: made by Dbc::markdown_table; a test compares -->\n");
        let (_, rest) = README.split_once(&begin).unwrap_or_else(|| panic!("no table of {name}"));
        let (shown, _) = rest.split_once("<!-- end -->").expect("the table has an end");
        assert_eq!(shown, table, "put this between the marks of {name} in dbc/README.md:\n\n{table}");
    }
}
