//! Enums whose variants have names in files: each variant is declared once, with its name.

/// Declares enums with the name of each variant, by which it is written, read and printed: all of them in order are `ALL`.
#[macro_export]
macro_rules! named {
    ($($(#[$of_enum:meta])* $visible:vis enum $enum:ident {
        $($(#[$of_variant:meta])* $variant:ident = $name:literal,)*
    })+) => {$(
        $(#[$of_enum])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize)]
        $visible enum $enum {
            $($(#[$of_variant])* #[serde(rename = $name)] $variant,)*
        }

        impl $enum {
            /// All, in the order in which tables list them.
            pub const ALL: [Self; [$($name),*].len()] = [$(Self::$variant),*];

            /// The name used in files and on screens.
            pub fn name(self) -> &'static str {
                match self { $(Self::$variant => $name),* }
            }

            /// The one of this name; `None` if there is none.
            pub fn from_name(name: &str) -> Option<Self> {
                Self::ALL.into_iter().find(|it| it.name() == name)
            }
        }

        $crate::schema_of_named!($enum: $($name),*);

        impl std::fmt::Display for $enum {
            fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                formatter.write_str(self.name())
            }
        }
    )+};
}
pub use named;

/// The schema of an enum with names, for [`schemas`](crate::schemas).
#[cfg(feature = "schemas")]
#[macro_export]
macro_rules! schema_of_named {
    ($enum:ident: $($name:literal),*) => {
        impl $crate::schemars::JsonSchema for $enum {
            fn schema_name() -> std::borrow::Cow<'static, str> {
                stringify!($enum).into()
            }

            fn json_schema(_: &mut $crate::schemars::SchemaGenerator) -> $crate::schemars::Schema {
                $crate::schemars::json_schema!({"type": "string", "enum": [$($name),*]})
            }
        }
    };
}

/// Nothing, without schemas.
#[cfg(not(feature = "schemas"))]
#[macro_export]
macro_rules! schema_of_named {
    ($($any:tt)*) => {};
}

#[cfg(test)]
mod tests {
    use crate::vocabulary::class::{AnnotationClass, Occlusion};
    use crate::vocabulary::criterion::CriterionKind;

    #[test]
    fn what_has_a_name_is_written_printed_and_read_by_it() {
        assert_eq!(CriterionKind::ALL.map(|it| it.to_string()), ["points", "bev-iou", "iou-3d", "centre"]);
        for it in AnnotationClass::ALL {
            let written = serde_json::to_string(&it).unwrap();
            assert_eq!(written, format!("{:?}", it.name()));
            assert_eq!(serde_json::from_str::<AnnotationClass>(&written).unwrap(), it);
            assert_eq!(AnnotationClass::from_name(it.name()), Some(it));
        }
        assert_eq!(
            (Occlusion::from_name("partly"), Occlusion::from_name("Partly")),
            (Some(Occlusion::Partly), None)
        );
        assert!(serde_json::from_str::<Occlusion>("\"Partly\"").is_err());
    }
}
