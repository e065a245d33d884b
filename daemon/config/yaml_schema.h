// Strict reading of YAML into plain structs. A schema is a list of keys, each of which defines the values that it
// allows.
//
// An unknown or repeated key, a wrong type and a value that is not allowed are errors that name the place, the key and
// what would be accepted. All errors of a document are collected; reading goes on behind each.
#pragma once

#include <yaml-cpp/yaml.h>

#include <charconv>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "common/log.h"
#include "common/result.h"

namespace gnomon::daemon::schema {

// What was found wrong, and the dotted keys that have no value for it, so that nothing is concluded from these.
struct Mistakes {
  std::vector<Error> errors;
  std::set<std::string> keys;
};

// Where YAML came from: a file, whose lines are named in errors, or the command line.
struct Source {
  std::string name;
  bool has_lines;
  Mistakes& mistakes;

  std::string at(const YAML::Mark& mark) const;  // "gnomond.yaml:12:3"
};

// A node, the dotted path that leads to it, and the position of its key.
struct Value {
  const Source& source;
  std::string path;
  YAML::Node node;
  YAML::Mark mark;

  std::string place() const { return source.at(mark); }

  void refuse(const std::string& why) const;           // adds "place: path: why" to the mistakes
  void not_allowed(const std::string& allowed) const;  // refuse(), with the value found and what is allowed
};

template <class T>
struct Key {
  std::string name;
  std::function<void(const Value&, T&)> read;
  // Adds the dotted names of what differs, this key's among them, each behind `above`.
  std::function<void(const T&, const T&, const std::string& above, std::vector<std::string>&)> differ;
  std::vector<std::string> below;  // dotted names of the keys below this one; empty if it has a value
  bool deprecated = false;         // still read, but not listed by all_paths()
};
template <class T>
using Keys = std::vector<Key<T>>;

template <class T>
std::vector<std::string> names_of(const Keys<T>& keys) {
  std::vector<std::string> names;
  for (const Key<T>& key : keys) names.push_back(key.name);
  return names;
}

template <class T>
std::vector<std::string> all_paths(const Keys<T>& keys) {
  std::vector<std::string> paths;
  for (const Key<T>& key : keys) {
    if (key.deprecated) continue;
    if (key.below.empty()) paths.push_back(key.name);
    for (const std::string& path : key.below) paths.push_back(key.name + "." + path);
  }
  return paths;
}

// The text of a plain (unquoted) scalar, nullopt for any other node: a quoted "1" is a string.
std::optional<std::string> plain_scalar(const YAML::Node& node);
std::optional<std::string> any_scalar(const YAML::Node& node);
std::string join(const std::vector<std::string>& words);

// The entries of a map by name, without those that are unknown or repeated, which are mistakes.
std::vector<std::pair<std::string, Value>> entries_of(const Value& value, const std::vector<std::string>& known);

template <class T>
void read_map(const Value& value, const Keys<T>& keys, T& out) {
  for (const auto& [name, entry] : entries_of(value, names_of(keys))) {
    for (const Key<T>& key : keys) {
      if (key.name == name) key.read(entry, out);
    }
  }
}

// The dotted names of the keys whose values differ.
template <class T>
std::vector<std::string> changed_keys(const Keys<T>& keys, const T& before, const T& after,
                                      const std::string& above = {}) {
  std::vector<std::string> changed;
  for (const Key<T>& key : keys) {
    if (!key.deprecated) key.differ(before, after, above, changed);
  }
  return changed;
}

// Key::differ of a key that is read into one member.
template <class T, class V>
auto differing_member(const std::string& name, V T::*member) {
  return
      [name, member](const T& before, const T& after, const std::string& above, std::vector<std::string>& changed) {
        if (!(before.*member == after.*member)) changed.push_back(above + name);
      };
}

// A key whose value is read by `parse`, which returns nullopt if the value is not allowed.
template <class T, class V, class Parse>
Key<T> scalar(std::string name, V T::*member, std::string allowed, Parse parse) {
  const auto differ = differing_member(name, member);
  return {std::move(name),
          [member, allowed = std::move(allowed), parse](const Value& value, T& out) {
            std::optional<V> parsed = parse(value.node);
            if (!parsed) return value.not_allowed(allowed);
            out.*member = std::move(*parsed);
          },
          differ,
          {}};
}

// An earlier name of `key`: it is read in the same way, and a warning in the log says which name to use.
template <class T>
Key<T> deprecated(std::string name, const Key<T>& key) {
  const auto read = [key](const Value& value, T& out) {
    log::warning("deprecated configuration key",
                 {{"place", value.place()}, {"key", value.path}, {"use", key.name}});
    key.read(value, out);
  };
  return {std::move(name), read, key.differ, key.below, true};
}

template <class V>
std::optional<V> parse_integer(const YAML::Node& node, int64_t min, int64_t max) {
  const auto text = plain_scalar(node);
  int64_t number = 0;
  if (!text) return std::nullopt;
  const auto [end, error] = std::from_chars(text->data(), text->data() + text->size(), number);
  if (error != std::errc{} || end != text->data() + text->size() || number < min || number > max) return {};
  return V(number);
}

// An integer, or a type that is constructed from one (milliseconds).
template <class T, class V>
Key<T> integer(std::string name, V T::*member, int64_t min, int64_t max, const std::string& note = "") {
  return scalar(std::move(name), member,
                "an integer from " + std::to_string(min) + " to " + std::to_string(max) + note,
                [min, max](const YAML::Node& node) { return parse_integer<V>(node, min, max); });
}

template <class T, class V>
Key<T> choice(std::string name, V T::*member, std::vector<std::pair<std::string, V>> choices) {
  std::vector<std::string> words;
  for (const auto& [word, meaning] : choices) words.push_back(word);
  return scalar(std::move(name), member, join(words),
                [choices = std::move(choices)](const YAML::Node& node) -> std::optional<V> {
                  const auto text = any_scalar(node);
                  for (const auto& [word, meaning] : choices) {
                    if (text == word) return meaning;
                  }
                  return std::nullopt;
                });
}

// A list whose items are read by `parse`, as in scalar().
template <class T, class V, class Parse>
Key<T> scalars(std::string name, std::vector<V> T::*member, std::string allowed, Parse parse) {
  return scalar(std::move(name), member, std::move(allowed),
                [parse](const YAML::Node& node) -> std::optional<std::vector<V>> {
                  if (!node.IsSequence()) return std::nullopt;
                  std::vector<V> items;
                  for (const YAML::Node& item : node) {
                    std::optional<V> parsed = parse(item);
                    if (!parsed) return std::nullopt;
                    items.push_back(std::move(*parsed));
                  }
                  return items;
                });
}

template <class T, class S>
Key<T> section(std::string name, S T::*member, Keys<S> keys) {
  auto below = all_paths(keys);
  const auto differ = [name, member, keys](const T& before, const T& after, const std::string& above,
                                           std::vector<std::string>& changed) {
    const auto inner = changed_keys(keys, before.*member, after.*member, above + name + ".");
    changed.insert(changed.end(), inner.begin(), inner.end());
  };
  return {std::move(name),
          [member, keys = std::move(keys)](const Value& value, T& out) { read_map(value, keys, out.*member); },
          differ, std::move(below)};
}

// A list of maps. `finish` checks and completes each item without mistakes; it returns an empty string, or what is wrong.
template <class T, class S, class Finish>
Key<T> sections(std::string name, std::vector<S> T::*member, Keys<S> keys, Finish finish) {
  auto below = all_paths(keys);
  const auto differ = differing_member(name, member);
  return {std::move(name),
          [member, keys = std::move(keys), finish](const Value& value, T& out) {
            const std::string allowed = "a list of maps with the keys " + join(names_of(keys));
            if (!value.node.IsSequence()) return value.not_allowed(allowed);
            std::vector<S> items;
            for (const YAML::Node& node : value.node) {
              const Value item{value.source, value.path, node, node.Mark()};
              const size_t before = value.source.mistakes.errors.size();
              S read_item{};
              if (node.IsMap()) {
                read_map(item, keys, read_item);
              } else {
                item.not_allowed(allowed);
              }
              if (value.source.mistakes.errors.size() > before) continue;
              const std::string wrong = finish(item, items, read_item);
              if (!wrong.empty()) {
                item.refuse(wrong);
                continue;
              }
              items.push_back(std::move(read_item));
            }
            out.*member = std::move(items);
          },
          differ, std::move(below)};
}

}  // namespace gnomon::daemon::schema
