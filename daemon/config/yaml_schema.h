// Strict reading of YAML into plain structs. A schema is a list of keys, each of which defines the values that it
// allows.
//
// An unknown or repeated key, a wrong type and a value that is not allowed are errors that name the place, the key and
// what would be accepted.
#pragma once

#include <yaml-cpp/yaml.h>

#include <charconv>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/log.h"
#include "common/result.h"

namespace gnomon::daemon::schema {

// Where YAML came from: a file, whose lines are named in errors, or the command line.
struct Source {
  std::string name;
  bool has_lines = true;

  std::string at(const YAML::Mark& mark) const;  // "gnomond.yaml:12"
};

// A node, the dotted path that leads to it, and the position of its key.
struct Value {
  const Source& source;
  std::string path;
  YAML::Node node;
  YAML::Mark mark;

  std::string place() const { return source.at(mark); }

  Error refuse(const std::string& why) const;           // "place: path: why"
  Error not_allowed(const std::string& allowed) const;  // refuse(), with the value found and what is allowed
};

template <class T>
struct Key {
  std::string name;
  std::function<Result<void>(const Value&, T&)> read;
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

// Checks that `value` is a map without repeated or unknown keys and returns its entries by name.
Result<std::vector<std::pair<std::string, Value>>> entries_of(const Value& value,
                                                              const std::vector<std::string>& known);

template <class T>
Result<void> read_map(const Value& value, const Keys<T>& keys, T& out) {
  auto entries = entries_of(value, names_of(keys));
  if (!entries) return entries.error();
  for (const auto& [name, entry] : *entries) {
    for (const Key<T>& key : keys) {
      if (key.name != name) continue;
      if (auto read = key.read(entry, out); !read) return read;
    }
  }
  return {};
}

// A key whose value is read by `parse`, which returns nullopt if the value is not allowed.
template <class T, class V, class Parse>
Key<T> scalar(std::string name, V T::*member, std::string allowed, Parse parse) {
  return {std::move(name),
          [member, allowed = std::move(allowed), parse](const Value& value, T& out) -> Result<void> {
            std::optional<V> parsed = parse(value.node);
            if (!parsed) return value.not_allowed(allowed);
            out.*member = std::move(*parsed);
            return {};
          },
          {}};
}

// An earlier name of `key`: it is read in the same way, and a warning in the log says which name to use.
template <class T>
Key<T> deprecated(std::string name, const Key<T>& key) {
  const auto read = [key](const Value& value, T& out) {
    log::warning("deprecated configuration key",
                 {{"place", value.place()}, {"key", value.path}, {"use", key.name}});
    return key.read(value, out);
  };
  return {std::move(name), read, key.below, true};
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
  return {
      std::move(name),
      [member, keys = std::move(keys)](const Value& value, T& out) { return read_map(value, keys, out.*member); },
      std::move(below)};
}

// A list of maps. `finish` checks and completes each item; it returns an empty string, or what is wrong.
template <class T, class S, class Finish>
Key<T> sections(std::string name, std::vector<S> T::*member, Keys<S> keys, Finish finish) {
  auto below = all_paths(keys);
  return {std::move(name),
          [member, keys = std::move(keys), finish](const Value& value, T& out) -> Result<void> {
            const std::string allowed = "a list of maps with the keys " + join(names_of(keys));
            if (!value.node.IsSequence()) return value.not_allowed(allowed);
            std::vector<S> items;
            for (const YAML::Node& node : value.node) {
              const Value item{value.source, value.path, node, node.Mark()};
              if (!node.IsMap()) return item.not_allowed(allowed);
              S read_item{};
              if (auto read = read_map(item, keys, read_item); !read) return read;
              const std::string wrong = finish(item, items, read_item);
              if (!wrong.empty()) return item.refuse(wrong);
              items.push_back(std::move(read_item));
            }
            out.*member = std::move(items);
            return {};
          },
          std::move(below)};
}

}  // namespace gnomon::daemon::schema
